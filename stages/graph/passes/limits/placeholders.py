"""Limits that only stand in for limits: a URDF must give numbers, also where nobody knows any."""

import math
from collections.abc import Mapping
from dataclasses import replace

from linkwright.stages.graph.passes.limits.joint_limits import with_each_dof
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, DofKind, Limits, Robot
from linkwright.stages.robot.text.globs import as_key, listed

FAR = 1000.0
"""An end of a range that is further [rad, m] is none, whatever its number: 159 turns, a kilometre."""

WHOLE = 10.0
"""A turn has no range that is symmetric and ends at a whole number of radians from here on."""

EFFORTS: Mapping[DofKind, float] = {"turn": 1e3, "slide": 1e6}
"""Powers of ten from here on are no effort [N m, N] that somebody measured."""

VELOCITY = 1e3
"""Powers of ten from here on are no velocity [rad/s, m/s] that somebody measured."""


def without_placeholders(robot: Robot, log: Diagnostics) -> Robot:
    """The robot without the limits that stand in for limits, but for those that the configuration gives:
    W-URDF-PLACEHOLDER names them all. Only where the source's format demands numbers."""
    found: dict[str, list[str]] = {}

    def checked(dof: Dof) -> Dof:
        made = _without(dof)
        for text in _changes(dof, made):
            found.setdefault(text, []).append(dof.name)
        return made

    robot = with_each_dof(robot, checked)
    if found:
        text = "; ".join(f"{what} ({listed(names)})" for what, names in found.items())
        names = {name for joints in found.values() for name in joints}
        entry = f"joints: {{{as_key(min(names))}: {{limits: [low, high], effort: N, velocity: N}}}}"
        hint = f"give the limits that the joints have, or the same numbers where they are meant: {entry}"
        text = f"numbers that stand for no limit are ignored: {text}"
        log.report("W-URDF-PLACEHOLDER", text, robot.provenance.document, hint)
    return robot


def _without(dof: Dof) -> Dof:
    """The dof with open ends, no effort and no velocity where placeholders stand for them."""
    if dof.kind not in EFFORTS:
        return dof
    limits, dynamics = dof.limits, dof.dynamics
    if "limits" not in dof.given:
        limits = _open(dof)
    if "effort" not in dof.given and _is_round(dynamics.effort, EFFORTS[dof.kind]):
        dynamics = replace(dynamics, effort=None)
    if "velocity" not in dof.given and _is_round(dynamics.velocity, VELOCITY):
        dynamics = replace(dynamics, velocity=None)
    return replace(dof, limits=limits, dynamics=dynamics)


def _open(dof: Dof) -> Limits:
    low, high = dof.limits.interval
    if dof.kind == "turn" and low == -high and WHOLE <= high < math.inf and high == math.floor(high):
        return Limits()
    return Limits(
        None if low <= -FAR else dof.limits.lower,
        None if high >= FAR else dof.limits.upper,
    )


def _is_round(value: float | None, least: float) -> bool:
    """Whether a value is a power of ten from `least` on."""
    return value is not None and value >= least and math.isclose(math.log10(value) % 1.0, 0.0, abs_tol=1e-12)


def _changes(before: Dof, after: Dof) -> list[str]:
    """What was taken away, as "effort 1000 N m"."""
    units = ("rad", "N m", "rad/s") if before.kind == "turn" else ("m", "N", "m/s")
    found = []
    if before.limits != after.limits:
        low, high = before.limits.interval
        found.append(f"range {low:g} to {high:g} {units[0]}")
    if before.dynamics.effort != after.dynamics.effort:
        found.append(f"effort {before.dynamics.effort:g} {units[1]}")
    if before.dynamics.velocity != after.dynamics.velocity:
        found.append(f"velocity {before.dynamics.velocity:g} {units[2]}")
    return found
