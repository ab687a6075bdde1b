"""Computes the values of a URDF's joints at a robot's poses."""

from collections.abc import Iterator

import numpy as np

from linkwright.stages.formats.numbers import least_of, number
from linkwright.stages.formats.urdf.names import UrdfNames
from linkwright.stages.robot.model.poses import rotation_from_quat, turns_from_rotation
from linkwright.stages.robot.model.robot import Dof, Robot, Value
from linkwright.stages.robot.motion.start_pose import HOME, keyframes


def states_of(robot: Robot, names: UrdfNames) -> dict[str, dict[str, str]]:
    """Returns pose → joint of the URDF → text of its value [rad or m], for `home` and the poses of the user.
    Free joints have no values. `names`: the names in the URDF."""
    pose_names = [HOME, *(keyframe.name for keyframe in robot.keyframes if keyframe.name != HOME)]
    poses = keyframes(robot)
    return {
        name: dict(pair for dof in robot.dofs for pair in _texts(dof, poses[name][dof.name], names))
        for name in pose_names
    }


def _texts(dof: Dof, value: Value, names: UrdfNames) -> Iterator[tuple[str, str]]:
    """Yields (joint of the URDF, text of its value) of a dof."""
    if dof.kind == "ball":
        angles = turns_from_rotation(rotation_from_quat(np.array(value)))
        for name, angle in zip(names.turns[dof.name], angles, strict=True):
            yield name, number(angle, least=least_of("ball"))
    elif dof.kind != "free":
        assert not isinstance(value, tuple)
        # A turn or slide has its dof's name in the URDF, also among several dofs of a joint.
        yield dof.name, number(value, least=least_of(dof.kind))
