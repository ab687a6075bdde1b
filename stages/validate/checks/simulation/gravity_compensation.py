"""No weight is taken off the robot but what its actuators carry."""

from collections.abc import Iterator

import numpy as np

from linkwright.stages.mujoco.names import body_index, joint_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, few, link, named
from linkwright.stages.validate.model.coordinates import SAME, joints_of


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of an MJCF: the share of each body's weight that is compensated, and by which joints."""
    findings = few((*_of_bodies(compiled), *_of_joints(compiled)))
    compensated = compiled.written.actuation.compensated
    detail = "what actuators carry of the weight" if compensated else "nothing carries weight but the joints"
    if findings:
        detail = f"differ: {', '.join(one.element for one in findings)}"
    yield compiled.within("compensated weight", float(len(findings)), 0.0, detail, findings)


def _of_bodies(compiled: CompiledModel) -> Iterator[Finding]:
    model = compiled.model
    wanted = np.zeros(model.nbody)
    for name, share in compiled.written.actuation.compensated:
        wanted[body_index(model, name)] = share
    own = {body_index(model, one.name) for one in compiled.robot.links}
    for body in () if compiled.sets("gravcomp") else sorted(own):
        if not abs(model.body_gravcomp[body] - wanted[body]) <= SAME:
            element = link(model.body(body).name, urdf=False)
            yield differs(element, "gravcomp", model.body_gravcomp[body], wanted[body])


def _of_joints(compiled: CompiledModel) -> Iterator[Finding]:
    """Where something is compensated: by its actuators, which have a limit, or by nothing that has one."""
    model, compensating = compiled.model, compiled.written.actuation.compensating
    for name, _, dof in joints_of(compiled.robot, urdf=False):
        found, wanted = bool(model.jnt_actgravcomp[joint_index(model, name)]), dof.name in compensating
        if found != wanted and not compiled.sets("actuatorgravcomp"):
            words = {True: "true", False: "false"}
            yield differs(named("joint", name), "actuatorgravcomp", words[found], words[wanted])
