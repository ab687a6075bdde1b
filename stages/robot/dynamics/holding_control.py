"""Computes the control and the state with which an actuator holds a pose."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from linkwright.stages.robot.model.actuation import Actuator

_FILTERS = ("filter", "filterexact")
"""Values of `dyntype` with which the state follows the control: at rest, both are equal."""


class _AffineForce(NamedTuple):
    """The force of an actuator at rest: gain · input + b0 + b1 · length, in MuJoCo's terms.

    The input is the control, or the state if there is one; length is gear times the value of the dof.
    """

    gain: float = 0.0
    b0: float = 0.0
    b1: float = 0.0


_NO_CONTROLLED_FORCE = _AffineForce()
"""The value for a force that is not of this form, or that the control does not set. Its gain is 0, so that
`holding_control` returns 0."""


def holding_control(actuator: Actuator, value: float, force: float) -> float:
    """Returns the control with which an actuator holds its dof at rest at `value` [rad or m], with the force
    `force` [N m or N] at the dof. The control is within the actuator's control range.

    The control of a position servo is beyond the value, by the servo's sag under the force. The control is 0
    for a velocity servo, for a damper, if the control changes the state without being equal to it at rest,
    and if the force does not have the form of `_AffineForce`.
    """
    gain, b0, b1 = _force_by_control(actuator)
    control = 0.0
    if gain:
        # The control of a velocity servo is its target speed, 0 at rest, whatever the force.
        actuator_force = 0.0 if actuator.type == "velocity" else force / actuator.gear
        actuator_force -= _integral_gain(actuator) * _integral(actuator, force)
        control = (actuator_force - b0 - b1 * actuator.gear * value) / gain
    if actuator.control is not None:
        control = min(max(control, actuator.control[0]), actuator.control[1])
    return control + 0.0  # -0 becomes 0


def can_hold(actuator: Actuator) -> bool:
    """Tells whether an actuator can make a force at rest, by its control or its state."""
    if actuator.type == "velocity":
        return False
    if actuator.type == "intvelocity" or _force_by_control(actuator).gain:
        return True
    # A bias that depends on the length is a spring, which holds without a control.
    return _general_force(dict(actuator.terms)).b1 != 0.0


def holding_state(actuator: Actuator, value: float, force: float) -> tuple[float, ...]:
    """Returns the activations with which an actuator holds its dof at rest at `value` [rad or m] with the
    force `force` [N m or N] at the dof.

    There are as many as MuJoCo has for the actuator: a target that is a state, the integral of a pid, and 0
    for all others.
    """
    terms = dict(actuator.terms)
    if actuator.type == "intvelocity":
        sag = force / (actuator.gear * actuator.kp) if actuator.kp else 0.0
        return (actuator.gear * value + sag,)
    if actuator.type == "pid":
        return _pid_state(actuator, value, force)
    if actuator.type == "dcmotor":
        # The current, the temperature and the bristles of the friction are states if they are modelled.
        return (0.0,) * sum(name in terms for name in ("inductance", "thermal", "lugre"))
    dynamics = terms.get("dyntype", "none")
    if dynamics == "none":
        return ()
    if dynamics in _FILTERS:
        return (holding_control(actuator, value, force),)
    if dynamics == "integrator":
        return (_integrator_state(actuator, value, force),)
    # A muscle, or the user's own dynamics.
    return (0.0,) * int(terms.get("actdim", "1"))


def _pid_state(actuator: Actuator, value: float, force: float) -> tuple[float, ...]:
    """Returns the states of a pid: the target if its speed has a limit (`slewmax`), and the integral if it
    has a gain (`ki`)."""
    terms = dict(actuator.terms)
    target = (holding_control(actuator, value, force),) if "slewmax" in terms else ()
    integral = (_integral(actuator, force),) if "ki" in terms else ()
    return (*target, *integral)


def _integrator_state(actuator: Actuator, value: float, force: float) -> float:
    """Returns the state of a general actuator that integrates its control. A file may write an intvelocity in
    this form."""
    gain, b0, b1 = _general_force(dict(actuator.terms))
    # Without gain, the state makes no force. Without b1, there is no spring: `can_hold` is false.
    if not (gain and b1):
        return 0.0
    return (force / actuator.gear - b0 - b1 * actuator.gear * value) / gain


def _integral_gain(actuator: Actuator) -> float:
    """Returns the force [N m or N] of a pid for each unit of its integral; 0 for other actuators."""
    return float(dict(actuator.terms).get("ki", 0.0)) if actuator.type == "pid" else 0.0


def _integral(actuator: Actuator, force: float) -> float:
    """Returns the integral of the error [rad s or m s] with which a pid makes a force at its dof, up to the
    limit of the integral; 0 for other actuators."""
    gain = _integral_gain(actuator)
    limit = float(dict(actuator.terms).get("imax", math.inf))
    return min(max(force / (actuator.gear * gain), -limit), limit) if gain else 0.0


def _force_by_control(actuator: Actuator) -> _AffineForce:
    """Returns the force as a function of the control, without the integral of a pid;
    `_NO_CONTROLLED_FORCE` if the control does not set the force."""
    if actuator.type == "motor":
        return _AffineForce(1.0)
    if actuator.type in ("position", "pid"):
        kp = actuator.kp or 0.0
        return _AffineForce(kp, 0.0, -kp)
    if actuator.type == "velocity":
        return _AffineForce(actuator.kv or 0.0)
    if actuator.type == "dcmotor":
        return _AffineForce(torque_per_volt(actuator))
    terms = dict(actuator.terms)
    if actuator.type == "general" and terms.get("dyntype", "none") in ("none", *_FILTERS):
        return _general_force(terms)
    return _NO_CONTROLLED_FORCE


def _general_force(terms: Mapping[str, str]) -> _AffineForce:
    """Returns the force by MuJoCo's own parameters of an actuator; `_NO_CONTROLLED_FORCE` if its gain
    is not fixed."""
    if terms.get("gaintype", "fixed") != "fixed":
        return _NO_CONTROLLED_FORCE
    gain = _numbers(terms, "gainprm", (1.0,))[0]
    if terms.get("biastype", "none") != "affine":
        return _AffineForce(gain)
    # MuJoCo takes 0 for parameters that are missing at the end.
    b0, b1 = (*_numbers(terms, "biasprm", ()), 0.0, 0.0)[:2]
    return _AffineForce(gain, b0, b1)


def torque_per_volt(actuator: Actuator) -> float:
    """Returns the torque per volt [N m/V] of a DC motor at rest, before the gear: the motor constant over the
    resistance, or the stall torque over the voltage if the motor has nominal values. The actuator must
    have `resistance` and `motorconst`, or three numbers in `nominal`."""
    terms = dict(actuator.terms)
    if "nominal" in terms:
        voltage, stall_torque, _ = _numbers(terms, "nominal", ())
        return stall_torque / voltage
    return volts_per_speed(actuator) / float(terms["resistance"])


def volts_per_speed(actuator: Actuator) -> float:
    """Returns the motor constant of a DC motor, before the gear: the voltage that it induces per speed [V
    s/rad]; the same number is its torque per current [N m/A].

    With nominal values, it is the voltage over the speed without load. If the file has both constants, MuJoCo
    takes their geometric mean. The actuator must have `motorconst`, or three numbers in `nominal`.
    """
    terms = dict(actuator.terms)
    if "nominal" in terms:
        voltage, _, no_load_speed = _numbers(terms, "nominal", ())
        return voltage / no_load_speed
    constants = _numbers(terms, "motorconst", ())
    return math.prod(constants) ** (1 / len(constants))


def _numbers(terms: Mapping[str, str], name: str, default: tuple[float, ...]) -> tuple[float, ...]:
    """Returns the numbers of an attribute; `default` if it is missing."""
    return tuple(float(number) for number in terms[name].split()) if name in terms else default
