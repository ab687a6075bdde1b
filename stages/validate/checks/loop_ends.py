"""A URDF cannot close a loop: it has a link for each of the two frames that must meet, at its place."""

from collections.abc import Iterator

import mujoco
import numpy as np

from stages.formats.urdf.names import urdf_names
from stages.robot.check import Check, Finding
from stages.robot.plural import count
from stages.robot.poses import inverse
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import SAME, body_index, distance, link_pose, pose_of
from stages.validate.findings import few, named, place_differs

CODE = "C-LOOP"


def check(compiled: CompiledModel) -> Iterator[Check]:
    robot, model = compiled.robot, compiled.model
    if not robot.loops:
        return
    data, names = mujoco.MjData(model), urdf_names(robot)
    mujoco.mj_kinematics(model, data)
    worst, found = 0.0, list[Finding]()
    for loop in robot.loops:
        ends = (loop.link_a, loop.a_from_frame), (loop.link_b, loop.b_from_frame)
        for name, (link, expected) in zip(names.ends[loop.name], ends, strict=True):
            index = body_index(model, name)
            if index < 0:
                worst = np.inf
                found.append(Finding(named("link", name), "name", f"there is no frame of {loop.name} here"))
                continue
            pose = inverse(link_pose(model, data, robot, link)) @ pose_of(data, index)
            worst = max(worst, distance(pose, expected))
            attributes = "origin xyz", "origin rpy"
            found += place_differs(named("joint", names.holders[name]), pose, expected, attributes, SAME)
    detail = f"the frames of {count(len(robot.loops), 'loop')}, each in its link [m, rad]"
    yield compiled.within("frames of loops", float(worst), SAME, detail, few(found))
