"""Reports servos that leave qpos0 after a plain reset: MuJoCo then sets each control to 0, whatever qpos0 is,
and MJCF cannot change that."""

from collections.abc import Iterator

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.errors import Diagnostic

MAX_MOTION = {"turn": 0.1, "slide": 0.01}
"""Kind of a dof → the largest motion [rad or m] of its servo after a plain reset that is not reported."""


def report_reset(written: Written) -> Iterator[Diagnostic]:
    """Reports servos that leave their position at qpos0 with a control of 0, or the nearest control in their
    range (I-RESET)."""
    servos = list(_leaving_servos(written))
    if servos:
        yield Diagnostic(
            "I-RESET",
            "mj_resetData sets every control to 0, whatever qpos0 is, so these servos then leave qpos0: "
            + ", ".join(servos),
            f"{written.robot.name}.xml",
            'start at a keyframe: mj_resetDataKeyframe(model, data, model.key("home").id)',
        )


def _leaving_servos(written: Written) -> Iterator[str]:
    """Yields the name of each servo that leaves qpos0, with its positions before and after."""
    kinds = {dof.name: dof.kind for dof in written.robot.dofs}
    for actuator in written.actuation.actuators:
        value = written.start[actuator.dof]
        if actuator.type not in ("position", "pid") or isinstance(value, tuple):
            continue
        low, high = actuator.control or (0.0, 0.0)
        target = min(max(0.0, low), high) / actuator.gear
        if abs(target - value) > MAX_MOTION[kinds[actuator.dof]]:
            yield f"{actuator.name} (from {value:.3g} to {target:.3g})"
