"""MJCF's actuators, by the shortcuts of MuJoCo's XML reference where they have one."""

from collections.abc import Iterator

from stages.formats.numbers import number
from stages.formats.xml import Element, element
from stages.robot.actuation import Actuation
from stages.robot.home_control import control_at
from stages.robot.model import Configuration


def write_actuators(root: Element, actuation: Actuation) -> None:
    """An element for each actuator, in the order of the dofs."""
    if not actuation.actuators:
        return
    above = element(root, "actuator")
    for one in actuation.actuators:
        element(
            above,
            one.type,
            name=one.name,
            joint=one.dof,
            gear=None if one.gear == 1.0 else number(one.gear),
            kp=_number(one.kp),
            kv=_number(one.kv),
            ctrlrange=_range(one.control),
            forcerange=_range(one.force),
            **dict(one.terms),
        )


def controls(actuation: Actuation, at: Configuration | None = None) -> str | None:
    """The `ctrl` of the keyframe `home`, or of another with these values; None without actuators."""
    return " ".join(number(one, max(1.0, abs(one))) for one in _controls(actuation, at)) or None


def _controls(actuation: Actuation, at: Configuration | None) -> Iterator[float]:
    for one in actuation.actuators:
        value = None if at is None else at[one.dof]
        yield one.home if value is None or isinstance(value, tuple) else control_at(one, value)


def _number(value: float | None) -> str | None:
    return None if value is None else number(value)


def _range(ends: tuple[float, float] | None) -> str | None:
    return None if ends is None else f"{number(ends[0])} {number(ends[1])}"
