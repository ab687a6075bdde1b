"""What the scene of the configuration is, and what robot.json says of it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from stages.export.json_values import as_float, as_floats, as_pose
from stages.robot.model import Array, Configuration, Robot, frozen
from stages.robot.poses import from_parts, rotation_from_rpy
from stages.robot.scene import Ground, Scene
from stages.robot.start_pose import keyframes

if TYPE_CHECKING:
    from stages.export.keys import ExportKeys
    from stages.export.scene_keys import GroundKeys
    from stages.export.standing import Stance


def scene_of(robot: Robot, keys: "ExportKeys", standing: "Stance", start: Configuration) -> Scene:
    """The scene around the robot, whose qpos0 is `start`."""
    option = keys.scene.option
    return Scene(
        frozen(standing.placed(start)),
        tuple((name, frozen(standing.placed(values, name))) for name, values in keyframes(robot).items()),
        None if keys.ground.kind == "none" else Ground(ground_pose(keys.ground), keys.ground.friction),
        {name: _plain(value) for name, value in option.given().items()},
        dict(option.flag.given()),
    )


def ground_pose(ground: "GroundKeys") -> Array:
    """world_from_ground (4, 4)."""
    return frozen(from_parts(rotation_from_rpy(ground.rpy), np.array(ground.xyz)))


def _plain(value: Any) -> Any:
    if isinstance(value, tuple | list):
        return tuple(map(float, value))
    return value if isinstance(value, str) else float(value)


def scene_record(scene: Scene) -> dict[str, Any]:
    """The table `scene`."""
    ground = scene.ground
    return {
        "pose": as_pose(scene.world_from_root),
        "keyframes": {name: as_pose(pose) for name, pose in scene.keyframes},
        "ground": None
        if ground is None
        else {"pose": as_pose(ground.world_from_ground), "friction": as_floats(ground.friction)},
        "option": {name: _record(value) for name, value in scene.option.items()},
        "flag": dict(scene.flag),
    }


def _record(value: Any) -> Any:
    if isinstance(value, str):
        return value
    return as_floats(value) if isinstance(value, tuple) else as_float(value)
