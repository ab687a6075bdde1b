"""Servo gains and armatures that nobody gave: from the weight and inertia on a dof, and the time step.

A servo sags by load / stiffness. It follows a moving target at a distance of 2 ζ / ω times the speed, ω its
natural frequency √(stiffness / inertia). Both bound the stiffness from below. What bounds it from above is
the integrator: a spring on an inertia is stable while ω h stays well below 2 (the semi-implicit Euler
method; Hairer, Lubich and Wanner, "Geometric Numerical Integration", I.1.4), so a dof without armature
gets as much as its own servo needs.
"""

import math

from stages.export.actuators.loads import Load
from stages.robot.dofs import DofKind

SAG = {"turn": 0.01, "slide": 0.001}
"""How far [rad, m] a servo with estimated stiffness sags at most."""

MARGIN = 2.0
"""The stiffness is so many times what the sag asks for: other loads come on top of the weight."""

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


def stiffness(kind: DofKind, load: Load, effort: float | None) -> float:
    """Of a position servo [N m/rad or N/m], at the dof. A load beyond its effort [N m or N] it cannot hold,
    however stiff it is."""
    return rounded(max(MARGIN * _held(load, effort) / SAG[kind], load.most_inertia * PACE**2))


def damping(kp: float, ratio: float, inertia: float) -> float:
    """Of a position servo [N m s/rad or N s/m], at the dof."""
    return rounded(2.0 * ratio * math.sqrt(kp * inertia))


def drag(kind: DofKind, load: Load, armature: float, effort: float | None) -> float:
    """Of a velocity servo [N m s/rad or N s/m], at the dof."""
    return rounded(max(MARGIN * _held(load, effort) / DRIFT[kind], (load.most_inertia + armature) * PACE))


def _held(load: Load, effort: float | None) -> float:
    return load.most if effort is None else min(load.most, effort)


def armature(kp: float, timestep: float, coupled: bool) -> float:
    """The inertia [kg m² or kg] that a servo of this stiffness needs to be stable by itself. `coupled`:
    whether other dofs move with it."""
    return rounded(kp * (timestep / (COUPLED_STEP if coupled else STEP)) ** 2, 2)


def rounded(value: float, digits: int = 3) -> float:
    """The value to so many digits: what is estimated is not known to more."""
    return float(f"{value:.{digits}g}")
