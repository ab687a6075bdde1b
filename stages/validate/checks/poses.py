"""At the saved configuration every part is where CAD's occurrence has it."""

from collections.abc import Iterator

import mujoco
import numpy as np

from stages.robot.check import Check, Finding
from stages.robot.poses import inverse
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import CAD_ERROR, distance, every_saved, link_pose, root_pose, set_values
from stages.validate.culprits import culprits
from stages.validate.findings import link as element
from stages.validate.findings import shown

CODE = "C-POSE"


def check(compiled: CompiledModel) -> Iterator[Check]:
    """The scene may put the robot anywhere: the pose of its root counts as that of the root's frame in CAD.
    A URDF has no scene: its root is at the origin."""
    robot, model = compiled.robot, compiled.model
    data = mujoco.MjData(model)
    set_values(model, data, robot, every_saved(robot), compiled.urdf)
    world_from_root = np.eye(4) if compiled.urdf else root_pose(model, data, robot)
    world_from_cad = world_from_root @ inverse(robot.world_from_root)
    worst, where, holder = 0.0, "", ""
    for link in robot.links:
        world_from_link = link_pose(model, data, robot, link.name)
        for part in link.parts:
            found = world_from_link @ part.link_from_part
            value = distance(found, world_from_cad @ part.world_from_part)
            if not value < worst:
                worst, where, holder = value, part.name, link.name
    detail = f"parts against CAD's occurrences at the saved pose [m, rad]; worst: {where}"
    findings: tuple[Finding, ...] = ()
    if not worst <= CAD_ERROR:
        attribute = "origin" if compiled.urdf else "pos"
        message = f"its part {where} is {shown(worst)} m or rad from CAD's occurrence"
        findings = culprits(compiled) or (Finding(element(holder, compiled.urdf), attribute, message),)
    yield compiled.within("poses", worst, CAD_ERROR, detail, findings)
