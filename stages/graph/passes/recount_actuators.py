"""Converts actuators to dofs whose values have another zero or sign, so that their forces stay the same."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from linkwright.stages.formats.numbers import exact
from linkwright.stages.robot.model.actuation import Actuator
from linkwright.stages.robot.model.robot import MateValue

Range = tuple[float, float] | None


def recounted(actuator: Actuator, mate_value: MateValue) -> Actuator:
    """Returns the actuator of a dof whose mate's value is zero + sign · value: equal forces at equal poses.

    With the length L = gear · zero + sign · L', a force gain · control + b₀ + b₁ L + b₂ dL/dt along L is,
    along L', sign times that. The control of a servo is the new value; where the gain depends on the
    length, as a damper's does, the control stays and the gain changes.
    """
    shift = actuator.gear * mate_value.of(0.0)
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
    target = shift if not affine_gain and bias[1] == -gain[0] else 0.0
    bias_names = {"biasprm"} & set(terms)
    if terms.get("biastype") == "affine":
        constant = bias[0] + bias[1] * shift + (gain[0] * target if not affine_gain else 0.0)
        bias = [mate_value.sign * constant + 0.0, *bias[1:]]
        bias_names |= {"biasprm"}
    if affine_gain:
        gain = [mate_value.sign * (gain[0] + gain[1] * shift) + 0.0, *gain[1:]]
        bias_names |= {"gainprm"}
    terms |= {
        name: _text(values) for name, values in (("biasprm", bias), ("gainprm", gain)) if name in bias_names
    }
    control = actuator.control
    if not affine_gain:
        by_rate = terms.get("dyntype") == "integrator"
        control = _converted_range(control, mate_value.sign, 0.0 if by_rate else target)
        if "actrange" in terms:
            low, high = _numbers(terms, "actrange", 2)
            terms["actrange"] = _text(_converted_range((low, high), mate_value.sign, target) or ())
    return replace(actuator, control=control, force=force, terms=tuple(terms.items()))


def _converted_range(pair: Range, sign: int, zero: float) -> Range:
    if pair is None:
        return None
    low, high = sorted(sign * (end - zero) + 0.0 for end in pair)
    return low, high


def _numbers(terms: Mapping[str, str], name: str, least: int) -> list[float]:
    default = "1" if name == "gainprm" else ""
    numbers = [float(number) for number in terms.get(name, default).split()]
    return numbers + [0.0] * (least - len(numbers))


def _text(values: Sequence[float]) -> str:
    last = max((index for index, value in enumerate(values) if value), default=0)
    return exact(values[: last + 1])
