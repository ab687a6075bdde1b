"""Checks that a simulation starts with its loops closed: every equality of an MJCF holds at qpos0."""

from collections.abc import Iterator

import mujoco

from linkwright.stages.robot.check import Check
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.model.equalities import LOOP_TOLERANCE, open_equalities, violation


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks MJCFs with equalities."""
    if compiled.urdf or not compiled.model.neq:
        return
    data = mujoco.MjData(compiled.model)
    mujoco.mj_forward(compiled.model, data)
    robot = compiled.robot
    parts = f"{count(len(robot.loops), 'loop')} and {count(len(robot.relations), 'relation')}"
    detail = f"{parts} at qpos0, distance from closed [m, rad]"
    equalities = open_equalities(compiled.model, data)
    yield compiled.within(
        "closed at qpos0", violation(compiled.model, data), LOOP_TOLERANCE, detail, equalities
    )
