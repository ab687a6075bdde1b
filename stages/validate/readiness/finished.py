"""Defines the finished robot by which points of sim-readiness are judged: its folder, XML and model."""

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
class FinishedRobot:
    """A robot whose files have been written."""

    folder: Path
    robot: Robot
    """The robot as the MJCF has it."""

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
        """The root of the robot's MJCF; raises NotApplicable if the file is not XML."""
        return _parsed(self.path)

    @cached_property
    def scene(self) -> Element:
        """The root of the scene; raises NotApplicable if there is no scene, or it is not XML."""
        path = self.folder / "scene.xml"
        if not path.exists():
            raise NotApplicable("no scene.xml was written")
        return _parsed(path)

    @cached_property
    def urdf(self) -> Element:
        """The root of the URDF; raises NotApplicable if there is no URDF, or it is not XML."""
        path = self.folder / f"{self.robot.name}.urdf"
        if not path.exists():
            raise NotApplicable("no URDF was written")
        return _parsed(path)

    @cached_property
    def geoms_by_body(self) -> dict[int, tuple[list[int], list[int]]]:
        """Body → its purely visual geoms and its colliding geoms, without those of the scene."""
        by_body = seen_and_solid(self.model)
        robot_geoms = {body: geoms for body, geoms in by_body.items() if body}
        # Geoms of body 0 are the robot's only if its root is the world; otherwise they are the scene's.
        if 0 in by_body and self.robot.root.name == "world":
            robot_geoms[0] = by_body[0]
        return robot_geoms

    @property
    def bodies(self) -> Iterator[tuple[int, str]]:
        """The bodies of the model, with those of a scene, by index and name; without the world."""
        return ((index, self.model.body(index).name) for index in range(1, self.model.nbody))

    @property
    def scalar_joints(self) -> list[int]:
        """The indices of the hinges and slides."""
        kinds = self.model.jnt_type
        return np.flatnonzero((kinds == HINGE) | (kinds == SLIDE)).tolist()

    @cached_property
    def home(self) -> Any:
        """MuJoCo's data at `home`, else at qpos0, with kinematics."""
        data = at_keyframe(self.model)
        mujoco.mj_kinematics(self.model, data)
        return data

    def name_of(self, kind: str, index: int) -> str:
        """Returns the name of the element of this kind (such as "joint") and index."""
        return str(getattr(self.model, kind)(int(index)).name)

    def failures_of(self, kinds: Iterable[str], otherwise: str) -> Iterator[str]:
        """Yields the failures of this run's checks of these kinds: codes without "C-". Raises NotApplicable
        with the message `otherwise` if no such check ran."""
        codes = {f"C-{kind}" for kind in kinds}
        checks = [check for check in self.checks if check.code in codes]
        if not checks:
            raise NotApplicable(otherwise)
        yield from (f"{check.name}: {check.detail}" for check in checks if not check.passed)


def _parsed(path: Path) -> Element:
    """Returns the root of a file. Raises NotApplicable if the file is not XML, since it may have been damaged
    after it was written."""
    try:
        return parse(path.read_bytes())
    except Malformed:
        raise NotApplicable(f"{path.name} is not XML") from None


PointJudge = Callable[[FinishedRobot], Iterable[str]]
"""Yields what a robot lacks to meet a point, as texts; nothing if the point is met. Raises NotApplicable if
the point does not apply."""


def has_noise(values: Any, share: float) -> bool:
    """Tells whether the numbers of an attribute include noise: a number that is not 0, but below this share
    of the largest."""
    sizes = np.abs(np.asarray(values))
    return bool(((sizes > 0) & (sizes < share * sizes.max(initial=0.0))).any())
