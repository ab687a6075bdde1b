"""Defines the scene and the keyframes of a robot.json."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from linkwright.stages.formats.robot_json.codec import UNREAD, JsonRecord
from linkwright.stages.formats.robot_json.values import (
    DofValue,
    Friction,
    Pose,
    PosePairs,
    SettingValue,
    Values,
)
from linkwright.stages.robot.model.robot import Keyframe
from linkwright.stages.robot.model.scene import Ground, Scene


@dataclass(frozen=True)
class GroundRecord(JsonRecord[Ground]):
    """A plane, whose z axis points out of it.

    pose: its pose in the world.
    friction: MuJoCo's sliding [-], torsional [m] and rolling [m] friction.
    """

    world_from_ground: Pose
    friction: Friction


@dataclass(frozen=True)
class SceneRecord(JsonRecord[Scene]):
    """The pose of the robot in the files.

    pose: the pose of its root in the world at qpos0.
    keyframes: keyframe → the pose of its root in the world.
    ground: the ground; null without a ground.
    option: attribute of MuJoCo's element → its value; other attributes have MuJoCo's defaults.
    flag: attribute of MuJoCo's element → its value; other attributes have MuJoCo's defaults.
    """

    world_from_root: Pose
    keyframes: PosePairs
    ground: GroundRecord | None
    option: Mapping[str, SettingValue]
    flag: Mapping[str, str]


@dataclass(frozen=True)
class KeyframeRecord(JsonRecord[Keyframe]):
    """A named pose.

    name: unique among keyframes.
    given: degree of freedom → the value that the user or the source gives.
    values: degree of freedom, also of a loop → its value.
    """

    name: str
    given: Values
    values: Annotated[Mapping[str, DofValue], UNREAD]
