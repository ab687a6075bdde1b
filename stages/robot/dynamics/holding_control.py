"""Computes the control and the state with which an actuator holds a pose."""

import math
from collections.abc import Mapping

from linkwright.stages.robot.model.actuation import Actuator

_FILTERS = ("filter", "filterexact")
"""Dynamics whose state follows the control: at rest it is the control."""


def control_at(actuator: Actuator, value: float, force: float) -> float:
    """Returns the control for which the actuator makes the `force` [N m or N] at its dof, at rest with the
    dof at `value`, within the control range: for a servo a target beyond the value, by its sag under that
    force.

    The force is gain · control + b₀ + b₁ · length + b₂ · speed; at rest a filter's state is its control. An
    actuator whose control moves its state in another way, a servo of speed, a damper, or an actuator of a
    kind that has no such form, rests at 0.
    """
    gain, b0, b1 = _affine(actuator)
    control = 0.0
    if gain:
        actuator_force = 0.0 if actuator.type == "velocity" else force / actuator.gear
        actuator_force -= _gain_of_integral(actuator) * _integral(actuator, force)
        control = (actuator_force - b0 - b1 * actuator.gear * value) / gain
    if actuator.control is not None:
        control = min(max(control, actuator.control[0]), actuator.control[1])
    return control + 0.0


def can_hold(actuator: Actuator) -> bool:
    """Returns whether a control or a state of the actuator makes it hold a force at rest."""
    if actuator.type == "velocity":
        return False
    _, _, stiffness = _affine_terms(dict(actuator.terms))
    return actuator.type == "intvelocity" or _affine(actuator)[0] != 0.0 or stiffness != 0.0


def state_at(actuator: Actuator, value: float, force: float) -> tuple[float, ...]:
    """Returns the activations with which the actuator makes the `force` at its dof, at rest with the dof at
    `value`. There are as many as MuJoCo has for it: the target if it is a state, the integral of a pid, else
    0."""
    terms = dict(actuator.terms)
    if actuator.type == "intvelocity":
        sag = force / (actuator.gear * actuator.kp) if actuator.kp else 0.0
        return (actuator.gear * value + sag,)
    if actuator.type == "pid":
        target = (control_at(actuator, value, force),) if "slewmax" in terms else ()
        return (*target, *((_integral(actuator, force),) if "ki" in terms else ()))
    if actuator.type == "dcmotor":
        return (0.0,) * sum(name in terms for name in ("inductance", "thermal", "lugre"))
    dynamics = terms.get("dyntype", "none")
    if dynamics == "none":
        return ()
    if dynamics in _FILTERS:
        return (control_at(actuator, value, force),)
    if dynamics == "integrator":
        # A file may write an intvelocity in this form.
        gain, b0, b1 = _affine_terms(terms)
        actuator_force = force / actuator.gear - b0 - b1 * actuator.gear * value
        return (actuator_force / gain if gain and b1 else 0.0,)
    return (0.0,) * int(terms.get("actdim", "1"))


def _gain_of_integral(actuator: Actuator) -> float:
    """Returns the force [N m or N] of a pid for each unit of its integral."""
    return float(dict(actuator.terms).get("ki", 0.0)) if actuator.type == "pid" else 0.0


def _integral(actuator: Actuator, force: float) -> float:
    """Returns the integral of the error [rad s or m s] with which a pid makes a force at its dof, up to its
    limit."""
    gain = _gain_of_integral(actuator)
    limit = float(dict(actuator.terms).get("imax", math.inf))
    return min(max(force / (actuator.gear * gain), -limit), limit) if gain else 0.0


def _affine(actuator: Actuator) -> tuple[float, float, float]:
    """Returns gain, b₀ and b₁ of the force; gain 0 if the force has no such form."""
    if actuator.type == "motor":
        return 1.0, 0.0, 0.0
    if actuator.type in ("position", "pid"):
        kp = actuator.kp or 0.0
        return kp, 0.0, -kp
    if actuator.type == "velocity":
        return actuator.kv or 0.0, 0.0, 0.0
    if actuator.type == "dcmotor":
        return torque_per_volt(actuator), 0.0, 0.0
    if actuator.type != "general":
        return 0.0, 0.0, 0.0
    terms = dict(actuator.terms)
    return _affine_terms(terms) if terms.get("dyntype", "none") in ("none", *_FILTERS) else (0.0, 0.0, 0.0)


def _affine_terms(terms: Mapping[str, str]) -> tuple[float, float, float]:
    """Returns the gain, b₀ and b₁ by MuJoCo's own parameters, where the gain multiplies the control or the
    state."""
    if terms.get("gaintype", "fixed") != "fixed":
        return 0.0, 0.0, 0.0
    gain = _numbers(terms, "gainprm", (1.0,))[0]
    if terms.get("biastype", "none") != "affine":
        return gain, 0.0, 0.0
    b0, b1 = (*_numbers(terms, "biasprm", ()), 0.0, 0.0)[:2]
    return gain, b0, b1


def torque_per_volt(actuator: Actuator) -> float:
    """Returns the torque per volt [N m/V] of a DC motor at rest, before the gear: the motor constant over the
    resistance, or stall torque over the voltage. With two constants MuJoCo takes their geometric mean."""
    terms = dict(actuator.terms)
    if "nominal" in terms:
        voltage, stall, _ = _numbers(terms, "nominal", ())
        return stall / voltage
    return volts_per_speed(actuator) / float(terms["resistance"])


def volts_per_speed(actuator: Actuator) -> float:
    """Returns the constant of a DC motor: the voltage that its turning takes [V s/rad], before the gear; the
    same number as its torque per current [N m/A]."""
    terms = dict(actuator.terms)
    if "nominal" in terms:
        voltage, _, speed = _numbers(terms, "nominal", ())
        return voltage / speed
    constants = _numbers(terms, "motorconst", ())
    return math.prod(constants) ** (1 / len(constants))


def _numbers(terms: Mapping[str, str], name: str, default: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(float(number) for number in terms[name].split()) if name in terms else default
