"""What a plain reset does to servos: MuJoCo sets each control to 0, whatever qpos0 is, and MJCF has no
other."""

from collections.abc import Iterator

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.errors import Diagnostic

FAR = {"turn": 0.1, "slide": 0.01}
"""How far [rad, m] a servo may go after a plain reset until that is reported."""


def reset(written: Written) -> Iterator[Diagnostic]:
    """I-RESET for servos that a control of 0, or what is nearest to it in their range, takes away from where
    they are at qpos0."""
    leaving = list(_leaving(written))
    if leaving:
        yield Diagnostic(
            "I-RESET",
            "mj_resetData sets each control to 0 whatever qpos0 is, so after it these servos leave qpos0: "
            + ", ".join(leaving),
            f"{written.robot.name}.xml",
            'start at a keyframe: mj_resetDataKeyframe(model, data, model.key("home").id)',
        )


def _leaving(written: Written) -> Iterator[str]:
    kinds = {dof.name: dof.kind for dof in written.robot.dofs}
    for actuator in written.actuation.actuators:
        value = written.start[actuator.dof]
        if actuator.type not in ("position", "pid") or isinstance(value, tuple):
            continue
        low, high = actuator.control or (0.0, 0.0)
        target = min(max(0.0, low), high) / actuator.gear
        if abs(target - value) > FAR[kinds[actuator.dof]]:
            yield f"{actuator.name} (from {value:.3g} to {target:.3g})"
