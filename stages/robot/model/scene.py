"""The scene that the files put a robot into, as far as a simulation of it depends on that."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # numpy comes with it
    from linkwright.stages.robot.model.arrays import Array

FLOOR = "floor"
"""The geom of a scene that is its ground."""

Setting = str | float | tuple[float, ...]
"""What MuJoCo takes: a word, a number, or several."""


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """A plane: its z axis is what points out of it. `friction`: MuJoCo's sliding [-], torsional [m] and
    rolling [m] friction."""

    world_from_ground: "Array"
    friction: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """`world_from_root` (4, 4): the pose of the robot's root at qpos0; `keyframes`: (name, pose) of each,
    since a free robot touches the ground in every one; `ground`: None where there is none; `option`, `flag`:
    what MuJoCo's elements of these names say, by attribute. What these leave out is MuJoCo's default."""

    world_from_root: "Array"
    keyframes: "tuple[tuple[str, Array], ...]"
    ground: Ground | None
    option: Mapping[str, Setting] = field(default_factory=dict)
    flag: Mapping[str, str] = field(default_factory=dict)
