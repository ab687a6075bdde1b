"""MJCF's actuators, by the shortcuts of MuJoCo's XML reference where they have one, and its sensors."""

from collections.abc import Iterator, Sequence

from stages.formats.numbers import TURN, number, spaced
from stages.formats.xml import Element, element
from stages.robot.actuation import Actuation
from stages.robot.home_control import control_at, state_at
from stages.robot.model import Configuration, Sensor


def write_actuation(root: Element, actuation: Actuation, sensors: Sequence[Sensor]) -> None:
    """An element for each actuator, in the order of the dofs, and for each sensor."""
    if actuation.actuators:
        _write_actuators(root, actuation)
    if sensors:
        above = element(root, "sensor")
        for one in sensors:
            element(
                above,
                one.type,
                name=one.name,
                **_ends(one),
                noise=number(one.noise) if one.noise else None,
                cutoff=number(one.cutoff) if one.cutoff else None,
            )


def _ends(sensor: Sensor) -> dict[str, str | None]:
    """What a sensor is on: named by its kind, of a frame's sensor by two attributes."""
    if not sensor.target:
        return {}
    if sensor.relative_to == "camera":
        return {"camera": sensor.name_of_relative, sensor.target: sensor.name_of_target}
    if not sensor.type.startswith("frame"):
        return {sensor.target: sensor.name_of_target}
    return {
        "objtype": sensor.target,
        "objname": sensor.name_of_target,
        "reftype": sensor.relative_to or None,
        "refname": sensor.name_of_relative or None,
    }


def _write_actuators(root: Element, actuation: Actuation) -> None:
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
    return " ".join(number(one, least=TURN) for one in _controls(actuation, at)) or None


def _controls(actuation: Actuation, at: Configuration | None) -> Iterator[float]:
    for one in actuation.actuators:
        value = None if at is None else at[one.dof]
        yield one.home if value is None or isinstance(value, tuple) else control_at(one, value)


def states(actuation: Actuation, at: Configuration) -> str | None:
    """The `act` of a keyframe with these values; None where all are 0."""
    every: list[float] = []
    for one in actuation.actuators:
        value = at[one.dof]
        every += () if isinstance(value, tuple) else state_at(one, value)
    return " ".join(number(one, least=TURN) for one in every) if any(every) else None


def _number(value: float | None) -> str | None:
    return None if value is None else number(value)


def _range(ends: tuple[float, float] | None) -> str | None:
    return None if ends is None else spaced(ends)
