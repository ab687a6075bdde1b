"""Makes the sensors of dofs and of actuators, which entries name or match by a glob."""

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Literal

from linkwright.stages.export.configuration.sensor_section import MEASURES
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Dof, Robot, Sensor
from linkwright.stages.robot.quantity_keys import as_typed, misfit
from linkwright.stages.robot.text.globs import matches_glob, no_match_hint

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.actuator_section import ActuatorSection
    from linkwright.stages.export.configuration.sensor_section import SensorSection

OF_BALLS = {"pos": "ballquat", "vel": "ballangvel"}
"""Measured quantity → MuJoCo's element for a ball."""

ENCODER = {"pos": "actuatorpos", "vel": "actuatorvel"}
"""Measured quantity → MuJoCo's element for an actuator's encoder."""


def joint_sensors(name: str, keys: "SensorSection", robot: Robot, log: Diagnostics) -> Iterator[Sensor]:
    """Yields the sensors of the dofs that an entry names, dof by dof. A glob skips quantities that a dof
    lacks."""
    where, glob = f"sensors.{name}.joints", keys.joints or "*"
    dofs = [dof for dof in robot.dofs if matches_glob(dof.name, glob)]
    if not dofs:
        _report_dof(glob, where, robot, log)
        return
    exact = [dof.name for dof in dofs] == [glob]
    for measured in keys.measured:
        reasons = [reason for dof in dofs if (reason := _missing_reason(dof, measured))]
        if len(reasons) == len(dofs):
            first = f"{dofs[0].name} {reasons[0]}"
            text = first if exact else f"no joint that {glob!r} matches has {measured}: {first}"
            log.report("E-SENSOR", text, where, f"leave {measured} out of measure, or name another joint")
    for dof in dofs:
        for measured in keys.measured:
            if _missing_reason(dof, measured):
                continue
            _check_units(measured, keys, dof, f"sensors.{name}", log)
            of_ball = measured in OF_BALLS and dof.kind == "ball"
            yield Sensor(
                f"{name}_{measured}" if exact else f"{name}_{dof.name}_{measured}",
                OF_BALLS[measured] if of_ball else MEASURES["joint"][measured],
                "joint",
                dof.name,
                noise=keys.noise_of(measured),
                cutoff=0.0 if of_ball and measured == "pos" else keys.cutoff_of(measured),
            )


def _check_units(measured: str, keys: "SensorSection", dof: Dof, where: str, log: Diagnostics) -> None:
    """Reports a length for a dof that turns, and an angle for one that slides (E-SENSOR)."""
    names: tuple[Literal["noise", "cutoff"], ...] = ("noise", "cutoff")
    for key in names:
        if wrong := misfit(keys.typed(key, measured), dof.kind):
            log.report("E-SENSOR", f"{key} of {measured} of {dof.name}: {wrong}", where, as_typed(dof.kind))


def _missing_reason(dof: Dof, measured: str) -> str:
    """Returns the reason why a dof lacks a quantity, in words; "" if it has the quantity."""
    if dof.kind == "free":
        return "moves freely: a sensor of type frame measures where its link is"
    if dof.kind == "ball":
        return "" if measured in OF_BALLS else f"is a ball: it has pos and vel, but no {measured}"
    if measured.startswith("limit_") and dof.limits.lower is None and dof.limits.upper is None:
        return f"has no limits, so it has no {measured}"
    return ""


def _report_dof(glob: str, where: str, robot: Robot, log: Diagnostics) -> None:
    of_joint = [dof.name for joint in robot.joints if matches_glob(joint.name, glob) for dof in joint.dofs]
    if of_joint:
        text = f"{glob!r} names a joint of several dofs (or several such joints), not one dof"
        log.report("E-GLOB", text, where, f"name one of its dofs: {', '.join(of_joint)}")
    else:
        report_unmatched(glob, "joint", [dof.name for dof in robot.dofs], where, log)


def report_unmatched(glob: str, kind: str, names: Collection[str], where: str, log: Diagnostics) -> None:
    """Reports a glob that matches none of the names of a kind of thing (E-GLOB)."""
    if not any(matches_glob(name, glob) for name in names):
        log.unmatched(
            "E-GLOB", f"no {kind} matches {glob!r}", where, no_match_hint(glob, {f"{kind}s": names}), glob
        )


def actuator_sensors(
    name: str, keys: "SensorSection", robot: Robot, actuation: Actuation, log: Diagnostics
) -> Iterator[Sensor]:
    """Yields the sensors of the actuators that an entry names, actuator by actuator."""
    glob = keys.actuators or "*"
    all_names = [actuator.name for actuator in actuation.actuators]
    names = [actuator_name for actuator_name in all_names if matches_glob(actuator_name, glob)]
    report_unmatched(glob, "actuator", all_names, f"sensors.{name}.actuators", log)
    exact = names == [glob]
    dofs = {dof.name: dof for dof in robot.dofs}
    driven = {actuator.name: dofs[actuator.dof] for actuator in actuation.actuators}
    for actuator in names:
        for measured in keys.measured:
            _check_units(measured, keys, driven[actuator], f"sensors.{name}", log)
            yield Sensor(
                f"{name}_{measured}" if exact else f"{name}_{actuator}_{measured}",
                MEASURES["actuator"][measured],
                "actuator",
                actuator,
                noise=keys.noise_of(measured),
                cutoff=keys.cutoff_of(measured),
            )


def encoders(
    actuation: Actuation, entries: Mapping[str, "ActuatorSection"], log: Diagnostics
) -> Iterator[tuple[str, Sensor]]:
    """Yields the sensors that the entries of `actuators` request, actuator by actuator, each with its key.

    Reports an entry that requests only sensors for a dof that nothing drives (E-SENSOR).
    """
    for glob, keys in entries.items():
        needs_actuator = keys.only_measures and (keys.encoder or keys.force) and glob != "*"
        if needs_actuator and not any(matches_glob(actuator.dof, glob) for actuator in actuation.actuators):
            text = f"nothing drives {glob!r}, so there is nothing to measure"
            log.report("E-SENSOR", text, f"actuators.{glob}", "give it a type or a motor too")
    for actuator in actuation.actuators:
        for key, measures in (("encoder", ENCODER), ("force", {"force": "actuatorfrc"})):
            requests = [
                (glob, value)
                for glob, keys in entries.items()
                if matches_glob(actuator.dof, glob)
                if (value := getattr(keys, key)) is not None
            ]
            if requests and requests[-1][1]:
                for measured, kind in measures.items():
                    sensor = Sensor(f"{actuator.name}_{measured}", kind, "actuator", actuator.name)
                    yield f"actuators.{requests[-1][0]}.{key}", sensor
