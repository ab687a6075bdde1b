"""Estimates servo gains and armatures from the weight and inertia on a dof, its effort, and the time step.

A servo sags by load / stiffness. It follows a moving target with a lag of 2 ζ / ω times the speed, where ζ is
its damping ratio and ω = √(stiffness / inertia) its natural frequency. Both bound the stiffness from below.

The effort bounds it from above: a servo that reaches its effort at a small error switches between both ends
of its force, which no real servo does. The time step h is the other bound from above: a spring on an inertia
is stable while ω h stays well below 2 (the semi-implicit Euler method; Hairer, Lubich and Wanner, "Geometric
Numerical Integration", I.1.4). A dof without armature gets the armature that its servo needs, up to the
inertia that the dof carries. If that is not enough, the servo is made softer.
"""

import math

from linkwright.stages.export.actuators.loads import Load
from linkwright.stages.robot.model.dofs import DofKind

SAG = {"turn": 0.01, "slide": 0.001}
"""Sag [rad, m] of a servo with estimated stiffness, if its effort and the time step allow it."""

LOAD_MARGIN = 2.0
"""Factor on the stiffness that the sag requires, since other loads come on top of the weight."""

MIN_ERROR_AT_EFFORT = {"turn": 0.1, "slide": 0.01}
"""Smallest error [rad, m] at which a servo with estimated stiffness reaches its effort."""

MIN_FREQUENCY = 2 * math.pi * 10
"""Smallest natural frequency [rad/s] of a servo on the inertia that it moves."""

MAX_DRIFT = {"turn": 0.1, "slide": 0.01}
"""Speed [rad/s, m/s] at which the weight may move a velocity servo whose target is zero."""

MAX_STEP_PHASE = 0.4
"""Largest phase ω h [rad] of a time step h, with the natural frequency ω of a servo on its armature alone."""

COUPLED_STEP_PHASE = 0.2
"""Replaces `MAX_STEP_PHASE` for a servo whose dof moves other dofs, by a loop or a relation. It is
smaller, since MuJoCo's implicit integrators damp the speeds after they have solved the constraints: a servo
that is fast for the time step leaves its followers behind."""

MAX_ARMATURE_SHARE = 1.0
"""Largest estimated armature, as a share of the inertia that the dof carries."""


def stiffness(kind: DofKind, load: Load, effort: float | None) -> float:
    """Returns the stiffness of a position servo [N m/rad or N/m] at the dof. `effort` [N m or N]: no servo
    can hold a load beyond it."""
    # A standing leg carries the whole robot. Only an unrealistically stiff servo would hold that within
    # `SAG`, so more sag is accepted.
    sag = MIN_ERROR_AT_EFFORT if load.standing else SAG
    required = max(
        LOAD_MARGIN * _load_within(load, effort) / sag[kind], load.largest_inertia * MIN_FREQUENCY**2
    )
    return rounded(required if effort is None else min(required, effort / MIN_ERROR_AT_EFFORT[kind]))


def max_stiffness(load: Load, timestep: float, coupled: bool) -> float:
    """Returns the largest stiffness [N m/rad or N/m] for which an armature within `MAX_ARMATURE_SHARE` is
    enough. `coupled`: whether the dof moves other dofs, by a loop or a relation."""
    return MAX_ARMATURE_SHARE * load.carried * (_max_step_phase(coupled) / timestep) ** 2


def armature(kp: float, load: Load | None, timestep: float, coupled: bool) -> float:
    """Returns the inertia [kg m² or kg] that a servo of this stiffness needs to be stable by itself, within
    `MAX_ARMATURE_SHARE`."""
    required = kp * (timestep / _max_step_phase(coupled)) ** 2
    return rounded(required if load is None else min(required, MAX_ARMATURE_SHARE * load.carried), 2)


def longest_timestep(kp: float, load: Load, coupled: bool) -> float:
    """Returns the longest time step [s] of one significant digit at which a servo of this stiffness needs no
    armature beyond `MAX_ARMATURE_SHARE`."""
    longest = _max_step_phase(coupled) * math.sqrt(MAX_ARMATURE_SHARE * load.carried / kp)
    step = rounded(longest, 1)
    if step <= longest:
        return step
    unit = 10.0 ** math.floor(math.log10(longest))
    return rounded(step - unit, 1)


def damping(kp: float, ratio: float, inertia: float) -> float:
    """Returns the damping of a position servo [N m s/rad or N s/m] at the dof. `kp` [N m/rad or N/m]: its
    stiffness; `ratio`: its damping ratio; `inertia` [kg m² or kg]: what it moves."""
    return rounded(2.0 * ratio * math.sqrt(kp * inertia))


def velocity_gain(kind: DofKind, load: Load, estimated_armature: float, effort: float | None) -> float:
    """Returns the gain of a velocity servo [N m s/rad or N s/m] at the dof. `estimated_armature` [kg m² or
    kg]: the armature that the dof gets, without one that is set, which the load includes; `effort` [N m or
    N]."""
    return rounded(
        max(
            LOAD_MARGIN * _load_within(load, effort) / MAX_DRIFT[kind],
            (load.largest_inertia + estimated_armature) * MIN_FREQUENCY,
        )
    )


def _load_within(load: Load, effort: float | None) -> float:
    """Returns the largest force [N m or N] of the load, but at most the effort."""
    return load.largest_force if effort is None else min(load.largest_force, effort)


def _max_step_phase(coupled: bool) -> float:
    """Returns the largest phase [rad] of a time step (see `MAX_STEP_PHASE`)."""
    return COUPLED_STEP_PHASE if coupled else MAX_STEP_PHASE


def rounded(value: float, digits: int = 3) -> float:
    """Returns the value with few significant digits, since an estimate is not more accurate."""
    return float(f"{value:.{digits}g}")
