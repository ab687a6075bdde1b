"""Checks that the robot's weight is compensated only as far as its actuators carry it."""

from collections.abc import Iterator

import numpy as np

from linkwright.stages.mujoco.names import body_index, joint_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, few, link, named
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE, joints_of


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the share of each body's weight that an MJCF compensates, and the joints that do."""
    findings = few((*_body_differences(compiled), *_joint_differences(compiled)))
    compensated = compiled.written.actuation.compensated
    detail = "the share of the weight that actuators carry" if compensated else "only the joints carry weight"
    if findings:
        detail = f"differ: {', '.join(finding.element for finding in findings)}"
    yield compiled.within("compensated weight", float(len(findings)), 0.0, detail, findings)


def _body_differences(compiled: CompiledModel) -> Iterator[Finding]:
    model = compiled.model
    expected = np.zeros(model.nbody)
    for name, share in compiled.written.actuation.compensated:
        expected[body_index(model, name)] = share
    bodies = {body_index(model, link.name) for link in compiled.robot.links}
    for body in () if compiled.sets("gravcomp") else sorted(bodies):
        if not abs(model.body_gravcomp[body] - expected[body]) <= ENGINE_TOLERANCE:
            element = link(model.body(body).name, urdf=False)
            yield differs(element, "gravcomp", model.body_gravcomp[body], expected[body])


def _joint_differences(compiled: CompiledModel) -> Iterator[Finding]:
    """Compares which joints compensate weight by their actuators, whose limits then include it."""
    model, compensating = compiled.model, compiled.written.actuation.compensating
    for name, _, dof in joints_of(compiled.robot, urdf=False):
        compensates, expected = (
            bool(model.jnt_actgravcomp[joint_index(model, name)]),
            dof.name in compensating,
        )
        if compensates != expected and not compiled.sets("actuatorgravcomp"):
            words = {True: "true", False: "false"}
            yield differs(named("joint", name), "actuatorgravcomp", words[compensates], words[expected])
