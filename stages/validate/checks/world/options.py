"""Checks that gravity, contacts, constraints and actuators are enabled in the simulation, and that its time
step is short enough.

Its findings are warnings, since a user may want no gravity. Whether a time step is too long for a robot shows
in the trial run.
"""

from collections.abc import Iterator

import mujoco

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import few, shown

MAX_TIMESTEP = 0.01
"""Time step [s] above which contact of small parts is missed; MuJoCo's default is a fifth of it."""

FLAGS = {
    "constraint": mujoco.mjtDisableBit.mjDSBL_CONSTRAINT,
    "equality": mujoco.mjtDisableBit.mjDSBL_EQUALITY,
    "limit": mujoco.mjtDisableBit.mjDSBL_LIMIT,
    "contact": mujoco.mjtDisableBit.mjDSBL_CONTACT,
    "gravity": mujoco.mjtDisableBit.mjDSBL_GRAVITY,
    "actuation": mujoco.mjtDisableBit.mjDSBL_ACTUATION,
}
"""Flag of an MJCF → its bit in `disableflags`."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks the options of the simulated file, except those that an MJCF source sets."""
    options, extras = compiled.model.opt, compiled.robot.mjcf or NO_EXTRAS
    of_source = {*dict(extras.option), *dict(extras.flag)}
    findings = []
    # Unlike `>= 0`, this also reports NaN.
    if not options.gravity[2] < 0:
        message = f"is {shown(options.gravity)} m/s², expected to point downwards, along -z"
        findings.append(Finding("option", "gravity", message))
    if not 0 < options.timestep <= MAX_TIMESTEP:
        findings.append(
            Finding("option", "timestep", f"is {shown(options.timestep)} s, at most {MAX_TIMESTEP:g} s")
        )
    for name, bit in FLAGS.items():
        if int(options.disableflags) & int(bit):
            findings.append(Finding("flag", name, "is disabled"))
    findings = [finding for finding in findings if finding.attribute not in of_source]
    detail = f"gravity {shown(options.gravity)} m/s², time step {shown(options.timestep)} s"
    yield compiled.within("options", float(len(findings)), 0.0, detail, few(findings), "warning")
