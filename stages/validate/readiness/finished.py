"""Defines a finished robot as the points of sim-readiness see it: its folder, its XML and its model."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.xml import Element, Malformed, parse
from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate.model.coordinates import HINGE, SLIDE
from linkwright.stages.validate.model.shapes import seen_and_solid


class NotApplicable(Exception):
    """The point does not apply to this robot, or is proved elsewhere. The message says why."""


@dataclass(frozen=True, eq=False)
class Finished:
    """A robot whose files are finished."""

    folder: Path
    robot: Robot
    """The robot in the form of the MJCF."""

    model: Any
    """The compiled scene; without a scene, the compiled robot."""

    checks: Sequence[Check] = ()
    """The results of this run."""

    geometry: Geometry | None = None
    """The shapes; None if they are not known."""

    @property
    def path(self) -> Path:
        """The robot's MJCF."""
        return self.folder / f"{self.robot.name}.xml"

    @cached_property
    def xml(self) -> Element:
        return parse(self.path.read_bytes())

    @cached_property
    def scene(self) -> Element:
        """The scene's XML; raises NotApplicable if there is no scene."""
        path = self.folder / "scene.xml"
        if not path.exists():
            raise NotApplicable("no scene.xml was written")
        return _parsed(path)

    @cached_property
    def urdf(self) -> Element:
        """The URDF; raises NotApplicable if there is no URDF."""
        path = self.folder / f"{self.robot.name}.urdf"
        if not path.exists():
            raise NotApplicable("no URDF was written")
        return _parsed(path)

    @cached_property
    def shapes(self) -> dict[int, tuple[list[int], list[int]]]:
        """Maps each body to its purely visual geoms and its colliding geoms, without those of the scene."""
        by_body = seen_and_solid(self.model)
        of_robot = {body: geoms for body, geoms in by_body.items() if body}
        return {**of_robot, **({0: by_body[0]} if 0 in by_body and self.robot.root.name == "world" else {})}

    @property
    def bodies(self) -> Iterator[tuple[int, str]]:
        """The bodies of the robot, by index and name."""
        return ((index, self.model.body(index).name) for index in range(1, self.model.nbody))

    @property
    def scalar_joints(self) -> list[int]:
        kinds = self.model.jnt_type
        return np.flatnonzero((kinds == HINGE) | (kinds == SLIDE)).tolist()

    @cached_property
    def home(self) -> Any:
        """MuJoCo's data at `home`, else at qpos0, with kinematics."""
        data = at_keyframe(self.model)
        mujoco.mj_kinematics(self.model, data)
        return data

    def name_of(self, kind: str, index: int) -> str:
        return str(getattr(self.model, kind)(int(index)).name)

    def proved_by(self, kinds: Iterable[str], otherwise: str) -> Iterator[str]:
        """Yields the failures of this run's checks of these kinds, or raises NotApplicable if none of the
        checks ran. A kind is a code without its first letter."""
        codes = {f"C-{kind}" for kind in kinds}
        checks = [check for check in self.checks if check.code in codes]
        if not checks:
            raise NotApplicable(otherwise)
        yield from (f"{check.name}: {check.detail}" for check in checks if not check.passed)


def _parsed(path: Path) -> Element:
    """Returns the root of a file, which may have been damaged since it was written."""
    try:
        return parse(path.read_bytes())
    except Malformed:
        raise NotApplicable(f"{path.name} is no XML") from None


Judge = Callable[[Finished], Iterable[str]]
"""Yields texts on what would meet a point, or nothing if it is met. Raises NotApplicable if the point does
not apply."""


def smallest_share(values: Any, limit: float) -> bool:
    """Tells whether an attribute's numbers include noise: a number that is tiny relative to the largest."""
    sizes = np.abs(np.asarray(values))
    return bool(((sizes > 0) & (sizes < limit * sizes.max(initial=0.0))).any())
