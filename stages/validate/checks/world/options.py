"""Checks that gravity, contacts, constraints and actuators are enabled in the simulation, and that its time
step is short enough.

Its findings are warnings, since a user may want no gravity. Whether a time step is too long for a robot shows
in the trial run.
"""

from collections.abc import Iterator
from typing import Any

import mujoco

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import few, shown

MAX_TIMESTEP = 0.01
"""Time step [s] above which contact of small parts is missed; MuJoCo's default is a fifth of it."""

DISABLE_FLAGS = {
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
    set_by_source = {*dict(extras.option), *dict(extras.flag)}
    findings = [finding for finding in _findings(options) if finding.attribute not in set_by_source]
    detail = f"gravity {shown(options.gravity)} m/s², time step {shown(options.timestep)} s"
    yield compiled.within("options", float(len(findings)), 0.0, detail, few(findings), "warning")


def _findings(options: Any) -> Iterator[Finding]:
    """Yields the faults of MuJoCo's options, and the kinds of physics that are disabled."""
    # Unlike `>= 0`, this also reports NaN.
    if not options.gravity[2] < 0:
        message = f"is {shown(options.gravity)} m/s², expected to point downwards, along -z"
        yield Finding("option", "gravity", message)
    if not 0 < options.timestep <= MAX_TIMESTEP:
        yield Finding(
            "option",
            "timestep",
            f"is {shown(options.timestep)} s, expected more than 0 and at most {MAX_TIMESTEP:g} s",
        )
    for name, bit in DISABLE_FLAGS.items():
        if int(options.disableflags) & int(bit):
            yield Finding("flag", name, "is disabled")
