"""MJCF's actuators, by the shortcuts of MuJoCo's XML reference where they have one."""

from stages.formats.numbers import number
from stages.formats.xml import Element, element
from stages.robot.actuation import Actuation, Actuator


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


def controls(actuation: Actuation) -> str | None:
    """The `ctrl` of the keyframe `home`; None without actuators."""
    return " ".join(home_of(one) for one in actuation.actuators) or None


def home_of(actuator: Actuator) -> str:
    """A control at home, as text."""
    return number(actuator.home, max(1.0, abs(actuator.home)))


def _number(value: float | None) -> str | None:
    return None if value is None else number(value)


def _range(ends: tuple[float, float] | None) -> str | None:
    return None if ends is None else f"{number(ends[0])} {number(ends[1])}"
