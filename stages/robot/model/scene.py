"""Describes the scene of the exported files around a robot, as far as a simulation depends on it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # numpy comes with it
    from linkwright.stages.robot.model.arrays import Array

FLOOR = "floor"
"""The geom of a scene that is its ground."""

Setting = str | float | tuple[float, ...]
"""A value of a MuJoCo setting: a word, a number, or several."""


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """A plane, whose z axis points out of it."""

    world_from_ground: "Array"
    friction: tuple[float, float, float]
    """MuJoCo's sliding [-], torsional [m] and rolling [m] friction."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """The scene of the exported files. Missing settings have MuJoCo's defaults."""

    world_from_root: "Array"
    """Pose (4, 4) of the robot's root at qpos0."""
    keyframes: "tuple[tuple[str, Array], ...]"
    """(name, pose of the root) of each keyframe: a free robot touches the ground in all of them."""
    ground: Ground | None
    """The ground; None if there is no ground."""
    option: Mapping[str, Setting] = field(default_factory=dict)
    """Attributes of MuJoCo's element <option>."""
    flag: Mapping[str, str] = field(default_factory=dict)
    """Attributes of MuJoCo's element <flag>."""
