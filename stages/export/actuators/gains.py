"""Servo gains and armatures that nobody gave: from the weight and inertia on a dof, what it can do, and the
time step.

A servo sags by load / stiffness. It follows a moving target at a distance of 2 ζ / ω times the speed, ω its
natural frequency √(stiffness / inertia). Both bound the stiffness from below.

From above it is bounded by the effort: a servo that reaches it at a small error switches between both ends of
its force, and follows like nothing that is built. The other bound is the integrator: a spring on an inertia
is stable while ω h stays well below 2 (the semi-implicit Euler method; Hairer, Lubich and Wanner, "Geometric
Numerical Integration", I.1.4), so a dof without armature gets as much as its own servo needs, but no more
than what it moves: beyond that the servo is softer.
"""

import math

from linkwright.stages.export.actuators.loads import Load
from linkwright.stages.robot.model.dofs import DofKind

SAG = {"turn": 0.01, "slide": 0.001}
"""How far [rad, m] a servo with estimated stiffness sags, where its effort and the time step allow it."""

MARGIN = 2.0
"""The stiffness is this many times what the sag asks for: other loads come on top of the weight."""

REACHED = {"turn": 0.1, "slide": 0.01}
"""The least error [rad, m] at which a servo with estimated stiffness reaches its effort."""

PACE = 2 * math.pi * 10
"""The least natural frequency [rad/s] of a servo with what it moves."""

DRIFT = {"turn": 0.1, "slide": 0.01}
"""The speed [rad/s, m/s] at which the weight may move a velocity servo that shall rest."""

STEP = 0.4
"""The natural frequency of a servo with its armature alone, times the time step."""

COUPLED_STEP = 0.2
"""The same where other dofs must follow, by a loop or a relation: MuJoCo's implicit integrators damp the
speeds after they solved the constraints, so a servo that is fast for the time step leaves its followers
behind."""

SHARE = 1.0
"""The largest armature that is estimated, as a share of the inertia that the dof carries."""


def stiffness(kind: DofKind, load: Load, effort: float | None) -> float:
    """Of a position servo [N m/rad or N/m], at the dof. `effort` [N m or N]: a load beyond it cannot be held,
    however stiff the servo is."""
    sag = REACHED if load.standing else SAG
    asked = max(MARGIN * _held(load, effort) / sag[kind], load.most_inertia * PACE**2)
    return rounded(asked if effort is None else min(asked, effort / REACHED[kind]))


def bearable(load: Load, timestep: float, coupled: bool) -> float:
    """The largest stiffness for which an armature within `SHARE` is enough. `coupled`: whether other dofs
    move with it."""
    return SHARE * load.carried * (_step(coupled) / timestep) ** 2


def armature(kp: float, load: Load | None, timestep: float, coupled: bool) -> float:
    """The inertia [kg m² or kg] that a servo of this stiffness needs to be stable by itself, within
    `SHARE`."""
    needed = kp * (timestep / _step(coupled)) ** 2
    return rounded(needed if load is None else min(needed, SHARE * load.carried), 2)


def longest_step(kp: float, load: Load, coupled: bool) -> float:
    """The time step [s] at which a servo of this stiffness needs no armature beyond `SHARE`."""
    return rounded(_step(coupled) * math.sqrt(SHARE * load.carried / kp), 1)


def damping(kp: float, ratio: float, inertia: float) -> float:
    """Of a position servo [N m s/rad or N s/m], at the dof."""
    return rounded(2.0 * ratio * math.sqrt(kp * inertia))


def drag(kind: DofKind, load: Load, armature: float, effort: float | None) -> float:
    """Of a velocity servo [N m s/rad or N s/m], at the dof."""
    return rounded(max(MARGIN * _held(load, effort) / DRIFT[kind], (load.most_inertia + armature) * PACE))


def _held(load: Load, effort: float | None) -> float:
    return load.most if effort is None else min(load.most, effort)


def _step(coupled: bool) -> float:
    return COUPLED_STEP if coupled else STEP


def rounded(value: float, digits: int = 3) -> float:
    """The value to so many digits: what is estimated is not known to more."""
    return float(f"{value:.{digits}g}")
