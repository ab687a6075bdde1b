"""Removes placeholder limits: a URDF must have numbers, even if nobody knows them."""

import math
from collections.abc import Mapping
from dataclasses import replace

from linkwright.stages.graph.passes.limits.joint_limits import with_each_dof
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, DofKind, Limits, Robot
from linkwright.stages.robot.text.globs import name_list, yaml_key

MIN_UNLIMITED_END = 1000.0
"""Smallest end of a range [rad, m] that counts as unlimited, whatever the number: 159 turns, a kilometre."""

MIN_UNLIMITED_TURN = 10.0
"""Smallest whole number of radians at which the end of a symmetric range of a turn counts as unlimited."""

MIN_UNKNOWN_EFFORTS: Mapping[DofKind, float] = {"turn": 1e3, "slide": 1e6}
"""Smallest power of ten that counts as an unknown effort [N m, N], since nobody measured it."""

MIN_UNKNOWN_VELOCITY = 1e3
"""Smallest power of ten that counts as an unknown velocity [rad/s, m/s], since nobody measured it."""


def without_placeholders(robot: Robot, log: Diagnostics) -> Robot:
    """Returns the robot without placeholder limits, except those that the configuration gives;
    reports them all (W-URDF-PLACEHOLDER). It applies only where the source's format demands numbers."""
    dofs_by_change: dict[str, list[str]] = {}

    def record_changes(dof: Dof) -> Dof:
        cleaned_dof = _without_placeholders(dof)
        for text in _changes(dof, cleaned_dof):
            dofs_by_change.setdefault(text, []).append(dof.name)
        return cleaned_dof

    robot = with_each_dof(robot, record_changes)
    if dofs_by_change:
        text = "; ".join(f"{change} ({name_list(names)})" for change, names in dofs_by_change.items())
        names = {name for joints in dofs_by_change.values() for name in joints}
        entry = f"joints: {{{yaml_key(min(names))}: {{limits: [low, high], effort: N, velocity: N}}}}"
        hint = f"give the limits that the joints have, or the same numbers where they are meant: {entry}"
        text = f"numbers that mean no limit are ignored: {text}"
        log.report("W-URDF-PLACEHOLDER", text, robot.provenance.document, hint)
    return robot


def _without_placeholders(dof: Dof) -> Dof:
    """Returns the dof with open ends, no effort and no velocity in place of placeholders."""
    if dof.kind not in MIN_UNKNOWN_EFFORTS:
        return dof
    limits, dynamics = dof.limits, dof.dynamics
    if "limits" not in dof.given:
        limits = _open_limits(dof)
    if "effort" not in dof.given and _is_round(dynamics.effort, MIN_UNKNOWN_EFFORTS[dof.kind]):
        dynamics = replace(dynamics, effort=None)
    if "velocity" not in dof.given and _is_round(dynamics.velocity, MIN_UNKNOWN_VELOCITY):
        dynamics = replace(dynamics, velocity=None)
    return replace(dof, limits=limits, dynamics=dynamics)


def _open_limits(dof: Dof) -> Limits:
    low, high = dof.limits.interval
    if (
        dof.kind == "turn"
        and low == -high
        and MIN_UNLIMITED_TURN <= high < math.inf
        and high == math.floor(high)
    ):
        return Limits()
    return Limits(
        None if low <= -MIN_UNLIMITED_END else dof.limits.lower,
        None if high >= MIN_UNLIMITED_END else dof.limits.upper,
    )


def _is_round(value: float | None, smallest: float) -> bool:
    """Tells whether a value is a power of ten, and at least `smallest`."""
    return (
        value is not None and value >= smallest and math.isclose(math.log10(value) % 1.0, 0.0, abs_tol=1e-12)
    )


def _changes(old: Dof, new: Dof) -> list[str]:
    """Returns the limits that were taken away, as "effort 1000 N m"."""
    units = ("rad", "N m", "rad/s") if old.kind == "turn" else ("m", "N", "m/s")
    changes = []
    if old.limits != new.limits:
        low, high = old.limits.interval
        changes.append(f"range {low:g} to {high:g} {units[0]}")
    if old.dynamics.effort != new.dynamics.effort:
        changes.append(f"effort {old.dynamics.effort:g} {units[1]}")
    if old.dynamics.velocity != new.dynamics.velocity:
        changes.append(f"velocity {old.dynamics.velocity:g} {units[2]}")
    return changes
