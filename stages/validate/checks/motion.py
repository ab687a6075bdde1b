"""The model moves as the robot does: links and frames at configurations spread over the dofs' values.

The robot's own kinematics is the reference: it was compared with CAD at the saved pose.
"""

import math
from collections.abc import Iterator
from typing import Any

import mujoco

from stages.formats.urdf.names import urdf_names
from stages.robot.check import Check
from stages.robot.kinematics import link_poses, rest_configuration
from stages.robot.model import Configuration
from stages.robot.poses import inverse
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import (
    SAME,
    distance,
    frame_pose,
    link_pose,
    root_pose,
    set_values,
    spread,
)
from stages.validate.culprits import culprits

CODE = "C-MOTION"


def check(compiled: CompiledModel) -> Iterator[Check]:
    robot, model = compiled.robot, compiled.model
    data = mujoco.MjData(model)
    worst, where = 0.0, ""
    if compiled.urdf:
        # At rest first: the values of a floating joint replace its origin, and would hide a wrong one.
        mujoco.mj_kinematics(model, data)
        worst, where = _worst(compiled, data, rest_configuration(robot))
    for turn in range(3):
        q = spread(robot, turn)
        set_values(model, data, robot, q, compiled.urdf)
        worst, where = max((worst, where), _worst(compiled, data, q), key=lambda found: found[0])
    detail = "links and frames at three configurations against the robot's own kinematics [m, rad]; worst: "
    findings = () if worst <= SAME else culprits(compiled)
    yield compiled.within("motion", worst, SAME, detail + where, findings)


def _worst(compiled: CompiledModel, data: Any, q: Configuration) -> tuple[float, str]:
    """The largest difference of a link or frame from the robot's own kinematics, relative to the root, and
    the name of that link or frame; infinite for one that is missing."""
    robot, model, urdf = compiled.robot, compiled.model, compiled.urdf
    root_from_world = inverse(root_pose(model, data, robot))
    links = link_poses(robot, q)
    names = urdf_names(robot).frames if urdf else {}
    pairs = [(name, link_pose(model, data, robot, name), pose) for name, pose in links.items()]
    for frame in robot.frames:
        found = frame_pose(model, data, names.get(frame.name, frame.name), urdf)
        pairs.append((frame.name, found, links[frame.link] @ frame.link_from_frame))
    off = [(distance(root_from_world @ found, pose), name) for name, found, pose in pairs]
    return max(((math.inf if math.isnan(value) else value), name) for value, name in off)
