"""Writes the actuators of an MJCF, with the shortcuts of MuJoCo's XML reference, and its sensors."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from linkwright.stages.formats.numbers import TURN, number, spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.dynamics.holding_control import holding_control, holding_state
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.mjcf_extras import MjcfExtras
from linkwright.stages.robot.model.robot import Configuration, Sensor


def write_actuation(
    root: Element,
    actuation: Actuation,
    sensors: Sequence[Sensor],
    extras: MjcfExtras,
) -> None:
    """Writes an element for each actuator, in the order of the dofs, and for each sensor. `extras`: the
    content of an MJCF source, with further attributes of both."""
    if actuation.actuators:
        _write_actuators(root, actuation, extras.attributes_of("actuator"))
    attributes_of = extras.attributes_of("sensor")
    if sensors:
        section = element(root, "sensor")
        for sensor in sensors:
            element(
                section,
                sensor.type,
                name=sensor.name,
                **_object_attributes(sensor),
                noise=number(sensor.noise) if sensor.noise else None,
                cutoff=number(sensor.cutoff) if sensor.cutoff else None,
                **attributes_of.get(sensor.name, {}),
            )


def _object_attributes(sensor: Sensor) -> dict[str, str | None]:
    """Returns the attributes that name the object of a sensor, and the object that it is relative to. The
    frame sensors of MuJoCo have separate attributes for the kind and the name of each."""
    if not sensor.target:
        return {}
    # A projection into a camera's image.
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


def _write_actuators(
    root: Element, actuation: Actuation, source_attributes: Mapping[str, Mapping[str, str]]
) -> None:
    """Writes the actuators. `source_attributes`: actuator → its attributes in an MJCF source."""
    section = element(root, "actuator")
    for actuator in actuation.actuators:
        element(
            section,
            actuator.type,
            name=actuator.name,
            joint=actuator.dof,
            gear=None if actuator.gear == 1.0 else number(actuator.gear),
            kp=_number(actuator.kp),
            kv=_number(actuator.kv),
            ctrlrange=_range(actuator.control),
            forcerange=_range(actuator.force),
            **{**dict(actuator.terms), **source_attributes.get(actuator.name, {})},
        )


@dataclass(frozen=True, slots=True)
class KeyedActuator:
    """The control and the states of an actuator in a keyframe."""

    name: str

    control: float
    """The value in `ctrl`."""

    states: tuple[float, ...]
    """The values in `act`."""


def keyed_actuators(actuation: Actuation, keyframe: str, values: Configuration) -> Iterator[KeyedActuator]:
    """Yields the actuators with the controls and states that hold the robot in a keyframe with these
    values."""
    for actuator in actuation.actuators:
        value, force = values[actuator.dof], actuator.force_at(keyframe)
        assert not isinstance(value, tuple), "an actuator drives one turn or slide"
        control = holding_control(actuator, value, force)
        yield KeyedActuator(actuator.name, control, holding_state(actuator, value, force))


def key_attributes(actuators: Sequence[KeyedActuator]) -> dict[str, str | None]:
    """Returns `act` and `ctrl` of a keyframe. `act` is None if all states are 0, MuJoCo's default; `ctrl` is
    None if there are no actuators."""
    states = [state for actuator in actuators for state in actuator.states]
    ctrl = " ".join(number(actuator.control, least=TURN) for actuator in actuators)
    act = " ".join(number(state, least=TURN) for state in states) if any(states) else None
    return {"act": act, "ctrl": ctrl or None}


def _number(value: float | None) -> str | None:
    """Returns the text of a number that may be unset."""
    return None if value is None else number(value)


def _range(ends: tuple[float, float] | None) -> str | None:
    """Returns the text of a range that may be unset."""
    return None if ends is None else spaced(ends)
