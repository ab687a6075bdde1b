"""Describes the scene around a robot in the exported files, as far as a simulation depends on it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # `arrays` imports numpy
    from linkwright.stages.robot.model.arrays import Array

FLOOR = "floor"
"""Name of the geom that is the ground of a scene."""

Setting = str | float | tuple[float, ...]
"""A value of a MuJoCo setting: a word, a number, or several."""


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """The plane z = 0 of its frame, solid below."""

    world_from_ground: "Array"
    """Pose (4, 4) of the ground's frame; its z axis points out of the ground."""
    friction: tuple[float, float, float]
    """MuJoCo's sliding [-], torsional [m] and rolling [m] friction."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """The scene of the exported files."""

    world_from_root: "Array"
    """Pose (4, 4) of the robot's root at qpos0."""
    keyframes: "tuple[tuple[str, Array], ...]"
    """(name, pose (4, 4) of the root) of each keyframe. In all of them a free robot touches the ground."""
    ground: Ground | None
    """The ground; None if there is no ground."""
    option: Mapping[str, Setting] = field(default_factory=dict)
    """Attributes of MuJoCo's element <option>; MuJoCo's defaults for missing attributes."""
    flag: Mapping[str, str] = field(default_factory=dict)
    """Attributes of MuJoCo's element <flag>; MuJoCo's defaults for missing attributes."""
