"""Builds the scene around the robot from the configuration."""

from typing import TYPE_CHECKING, Any

import numpy as np

from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array, Configuration, Robot, frozen
from linkwright.stages.robot.model.scene import Ground, Scene
from linkwright.stages.robot.motion.start_pose import keyframes

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.scene_section import GroundSection
    from linkwright.stages.export.ground.standing import Placement
    from linkwright.stages.export.section import ExportSections


def scene_of(robot: Robot, keys: "ExportSections", standing: "Placement", start: Configuration) -> Scene:
    """Returns the scene around the robot. `start`: the values of the dofs at qpos0."""
    option = keys.scene.option
    return Scene(
        frozen(standing.placed(start)),
        tuple((name, frozen(standing.placed(values, name))) for name, values in keyframes(robot).items()),
        None if keys.ground.kind == "none" else Ground(ground_pose(keys.ground), keys.ground.friction),
        {name: _plain(value) for name, value in option.explicit().items()},
        dict(option.flag.explicit()),
    )


def ground_pose(ground: "GroundSection") -> Array:
    """Returns world_from_ground (4, 4)."""
    return frozen(from_parts(rotation_from_rpy(ground.rpy), np.array(ground.xyz)))


def _plain(value: Any) -> Any:
    """Returns the value of an option as text, a float, or a tuple of floats."""
    if isinstance(value, tuple | list):
        return tuple(map(float, value))
    return value if isinstance(value, str) else float(value)
