"""MJCF's actuators, by the shortcuts of MuJoCo's XML reference where they have one, and its sensors."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from linkwright.stages.formats.numbers import TURN, number, spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.dynamics.holding_control import control_at, state_at
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.mjcf_extras import MjcfExtras
from linkwright.stages.robot.model.robot import Configuration, Sensor


def write_actuation(
    root: Element,
    actuation: Actuation,
    sensors: Sequence[Sensor],
    extras: MjcfExtras,
) -> None:
    """An element for each actuator, in the order of the dofs, and for each sensor, with the attributes of an
    MJCF source."""
    if actuation.actuators:
        _write_actuators(root, actuation, extras.attributes_of("actuator"))
    more = extras.attributes_of("sensor")
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
                **more.get(one.name, {}),
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


def _write_actuators(root: Element, actuation: Actuation, extras: Mapping[str, Mapping[str, str]]) -> None:
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
            **{**dict(one.terms), **extras.get(one.name, {})},
        )


@dataclass(frozen=True, slots=True)
class KeyedActuator:
    """An actuator in a keyframe: its control and its states."""

    name: str
    control: float
    states: tuple[float, ...]


def drives(actuation: Actuation, keyframe: str, at: Configuration) -> Iterator[KeyedActuator]:
    """The actuators in a keyframe with these values, as they hold the robot there."""
    for actuator in actuation.actuators:
        value, force = at[actuator.dof], actuator.force_at(keyframe)
        assert not isinstance(value, tuple), "an actuator drives one turn or slide"
        control = control_at(actuator, value, force)
        yield KeyedActuator(actuator.name, control, state_at(actuator, value, force))


def key_attributes(every: Sequence[KeyedActuator]) -> dict[str, str | None]:
    """`act` and `ctrl` of a keyframe: no `act` where all states are 0, and no `ctrl` without actuators."""
    states = [state for drive in every for state in drive.states]
    ctrl = " ".join(number(drive.control, least=TURN) for drive in every)
    act = " ".join(number(state, least=TURN) for state in states) if any(states) else None
    return {"act": act, "ctrl": ctrl or None}


def _number(value: float | None) -> str | None:
    return None if value is None else number(value)


def _range(ends: tuple[float, float] | None) -> str | None:
    return None if ends is None else spaced(ends)
