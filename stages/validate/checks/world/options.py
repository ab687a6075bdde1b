"""The simulation is of a world with weight, contact and joints that hold, in steps that engines bear.

Only a warning: a user may want no weight. What a step is too long for shows in the trial run.
"""

from collections.abc import Iterator

import mujoco

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import few, shown

LONGEST = 0.01
"""A time step [s] beyond which contact of small parts is missed: MuJoCo's own default is a fifth of it."""

FLAGS = {
    "constraint": mujoco.mjtDisableBit.mjDSBL_CONSTRAINT,
    "equality": mujoco.mjtDisableBit.mjDSBL_EQUALITY,
    "limit": mujoco.mjtDisableBit.mjDSBL_LIMIT,
    "contact": mujoco.mjtDisableBit.mjDSBL_CONTACT,
    "gravity": mujoco.mjtDisableBit.mjDSBL_GRAVITY,
    "actuation": mujoco.mjtDisableBit.mjDSBL_ACTUATION,
}


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of the file that is simulated, but for what an MJCF source says."""
    options, extras = compiled.model.opt, compiled.robot.mjcf or NO_EXTRAS
    of_source = {*dict(extras.option), *dict(extras.flag)}
    found = []
    if not options.gravity[2] < 0:
        message = f"is {shown(options.gravity)} m/s², expected to point downwards, along -z"
        found.append(Finding("option", "gravity", message))
    if not 0 < options.timestep <= LONGEST:
        found.append(Finding("option", "timestep", f"is {shown(options.timestep)} s, at most {LONGEST:g} s"))
    for name, bit in FLAGS.items():
        if int(options.disableflags) & int(bit):
            found.append(Finding("flag", name, "is disabled"))
    found = [one for one in found if one.attribute not in of_source]
    detail = f"gravity {shown(options.gravity)} m/s², time step {shown(options.timestep)} s"
    yield compiled.within("options", float(len(found)), 0.0, detail, few(found), "warning")
