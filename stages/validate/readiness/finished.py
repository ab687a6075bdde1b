"""A finished robot as the points of sim-readiness look at it: its folder, its XML, its model."""

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


class Aside(Exception):
    """Raised by a point that says nothing of this robot, or is proved elsewhere, with the reason."""


@dataclass(frozen=True, eq=False)
class Finished:
    """`model`: the compiled scene, or the robot's file where there is none. `robot`: as the MJCF has it.
    `checks`: the results of this run. `geometry` is None where nothing is known of the shapes."""

    folder: Path
    robot: Robot
    model: Any
    checks: Sequence[Check] = ()
    geometry: Geometry | None = None

    @property
    def path(self) -> Path:
        """The robot's MJCF."""
        return self.folder / f"{self.robot.name}.xml"

    @cached_property
    def xml(self) -> Element:
        return parse(self.path.read_bytes())

    @cached_property
    def scene(self) -> Element:
        """The scene's XML; Aside where there is none."""
        path = self.folder / "scene.xml"
        if not path.exists():
            raise Aside("no scene.xml was written")
        return _parsed(path)

    @cached_property
    def urdf(self) -> Element:
        """The URDF; Aside where there is none."""
        path = self.folder / f"{self.robot.name}.urdf"
        if not path.exists():
            raise Aside("no URDF was written")
        return _parsed(path)

    @cached_property
    def shapes(self) -> dict[int, tuple[list[int], list[int]]]:
        """By body: the geoms that are only seen, and those that collide; not those of the scene."""
        found = seen_and_solid(self.model)
        own = {body: geoms for body, geoms in found.items() if body}
        return {**own, **({0: found[0]} if 0 in found and self.robot.root.name == "world" else {})}

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
        """What the checks of this run of these kinds, their codes without the first letter, do not accept;
        Aside where none of them ran."""
        codes = {f"C-{kind}" for kind in kinds}
        own = [check for check in self.checks if check.code in codes]
        if not own:
            raise Aside(otherwise)
        yield from (f"{one.name}: {one.detail}" for one in own if not one.passed)


def _parsed(path: Path) -> Element:
    """The root of a file, which may have been broken since it was written."""
    try:
        return parse(path.read_bytes())
    except Malformed:
        raise Aside(f"{path.name} is no XML") from None


Judge = Callable[[Finished], Iterable[str]]
"""What would raise a point, in words; nothing where it is met. Raises Aside where it says nothing here."""


def smallest_share(values: Any, limit: float) -> bool:
    """Whether an attribute's numbers hold one that is noise beside its largest."""
    sizes = np.abs(np.asarray(values))
    return bool(((sizes > 0) & (sizes < limit * sizes.max(initial=0.0))).any())
