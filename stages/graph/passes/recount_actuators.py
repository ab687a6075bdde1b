"""Converts actuators to dofs whose values have another zero or sign, so that the forces stay the same."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from linkwright.stages.formats.numbers import exact
from linkwright.stages.robot.model.actuation import Actuator
from linkwright.stages.robot.model.robot import MateValue

Range = tuple[float, float] | None


def recount_actuator(actuator: Actuator, mate_value: MateValue) -> Actuator:
    """Returns the actuator for a dof whose mate's value is zero + sign · value, with equal forces at equal
    poses. The actuator's length L is gear · zero + sign · L' with the new length L'. A force gain · control +
    b₀ + b₁ L + b₂ dL/dt along L is sign times as large along L'. The control of a servo becomes the new
    value. If the gain depends on the length, as that of a damper does, the control stays, and the gain
    changes.
    """
    shift = actuator.gear * mate_value.to_mate(0.0)
    force = _converted_range(actuator.force, mate_value.sign, 0.0)
    if actuator.type != "general":
        target = shift if actuator.type == "position" else 0.0
        return replace(
            actuator, control=_converted_range(actuator.control, mate_value.sign, target), force=force
        )
    terms = dict(actuator.terms)
    bias = _numbers(terms, "biasprm", 3)
    gain = _numbers(terms, "gainprm", 3)
    affine_gain = terms.get("gaintype") == "affine"
    # A servo has b₁ = -gain: its control is a length, whose zero moves too.
    target = shift if not affine_gain and bias[1] == -gain[0] else 0.0
    written_names = {"biasprm"} & set(terms)
    if terms.get("biastype") == "affine":
        constant = bias[0] + bias[1] * shift + (gain[0] * target if not affine_gain else 0.0)
        bias = [mate_value.sign * constant + 0.0, *bias[1:]]
        written_names |= {"biasprm"}
    if affine_gain:
        gain = [mate_value.sign * (gain[0] + gain[1] * shift) + 0.0, *gain[1:]]
        written_names |= {"gainprm"}
    terms |= {
        name: _text(values)
        for name, values in (("biasprm", bias), ("gainprm", gain))
        if name in written_names
    }
    control = actuator.control
    if not affine_gain:
        is_rate = terms.get("dyntype") == "integrator"
        control = _converted_range(control, mate_value.sign, 0.0 if is_rate else target)
        if "actrange" in terms:
            low, high = _numbers(terms, "actrange", 2)
            terms["actrange"] = _text(_converted_range((low, high), mate_value.sign, target) or ())
    return replace(actuator, control=control, force=force, terms=tuple(terms.items()))


def _converted_range(pair: Range, sign: int, zero: float) -> Range:
    if pair is None:
        return None
    low, high = sorted(sign * (end - zero) + 0.0 for end in pair)
    return low, high


def _numbers(terms: Mapping[str, str], name: str, min_length: int) -> list[float]:
    default = "1" if name == "gainprm" else ""
    numbers = [float(number) for number in terms.get(name, default).split()]
    return numbers + [0.0] * (min_length - len(numbers))


def _text(values: Sequence[float]) -> str:
    last_nonzero = max((index for index, value in enumerate(values) if value), default=0)
    return exact(values[: last_nonzero + 1])
