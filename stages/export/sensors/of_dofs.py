"""Makes the sensors of dofs and of actuators, which entries name or match by a glob."""

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Literal

from linkwright.stages.export.configuration.sensor_section import MEASURES
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Dof, Robot, Sensor
from linkwright.stages.robot.quantity_keys import misfit, unit_hint
from linkwright.stages.robot.text.globs import matches_glob, no_match_hint

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.actuator_section import ActuatorSection
    from linkwright.stages.export.configuration.sensor_section import SensorSection

BALL_ELEMENTS = {"pos": "ballquat", "vel": "ballangvel"}
"""Measured quantity → MuJoCo's element for a ball."""

ENCODER_ELEMENTS = {"pos": "actuatorpos", "vel": "actuatorvel"}
"""Measured quantity → MuJoCo's element for an actuator's encoder."""


def joint_sensors(name: str, section: "SensorSection", robot: Robot, log: Diagnostics) -> Iterator[Sensor]:
    """Yields the sensors of the dofs that an entry of `sensors` names, dof by dof, without quantities that a
    dof lacks. Reports E-GLOB if no dof matches, and E-SENSOR for a quantity that all matched dofs lack and
    for a wrong unit."""
    where, glob = f"sensors.{name}.joints", section.joints or "*"
    dofs = [dof for dof in robot.dofs if matches_glob(dof.name, glob)]
    if not dofs:
        _report_no_dof(glob, where, robot, log)
        return
    is_named = [dof.name for dof in dofs] == [glob]
    for measured in section.measured:
        reasons = [reason for dof in dofs if (reason := _missing_reason(dof, measured))]
        if len(reasons) == len(dofs):
            example = f"{dofs[0].name} {reasons[0]}"
            text = example if is_named else f"no joint that {glob!r} matches has {measured}: {example}"
            log.report("E-SENSOR", text, where, f"leave {measured} out of measure, or name another joint")
    for dof in dofs:
        for measured in section.measured:
            if _missing_reason(dof, measured):
                continue
            _check_units(measured, section, dof, f"sensors.{name}", log)
            is_of_ball = measured in BALL_ELEMENTS and dof.kind == "ball"
            yield Sensor(
                _sensor_name(name, "" if is_named else dof.name, measured),
                BALL_ELEMENTS[measured] if is_of_ball else MEASURES["joint"][measured],
                "joint",
                dof.name,
                noise=section.noise_of(measured),
                # A quaternion has no cutoff.
                cutoff=0.0 if is_of_ball and measured == "pos" else section.cutoff_of(measured),
            )


def _sensor_name(entry: str, owner: str, measured: str) -> str:
    """Joins the name of an entry, of the dof or actuator if the entry has a glob, and of the quantity."""
    return "_".join(filter(None, (entry, owner, measured)))


def _check_units(measured: str, section: "SensorSection", dof: Dof, where: str, log: Diagnostics) -> None:
    """Reports a length for a dof that turns, and an angle for one that slides (E-SENSOR)."""
    keys_with_units: tuple[Literal["noise", "cutoff"], ...] = ("noise", "cutoff")
    for key in keys_with_units:
        if wrong := misfit(section.typed(key, measured), dof.kind):
            log.report("E-SENSOR", f"{key} of {measured} of {dof.name}: {wrong}", where, unit_hint(dof.kind))


def _missing_reason(dof: Dof, measured: str) -> str:
    """Returns the reason why a dof lacks a quantity, in words; "" if it has the quantity."""
    if dof.kind == "free":
        return "moves freely: a sensor of type frame measures where its link is"
    if dof.kind == "ball":
        return "" if measured in BALL_ELEMENTS else f"is a ball: it has pos and vel, but no {measured}"
    if measured.startswith("limit_") and dof.limits.lower is None and dof.limits.upper is None:
        return f"has no limits, so it has no {measured}"
    return ""


def _report_no_dof(glob: str, where: str, robot: Robot, log: Diagnostics) -> None:
    """Reports a glob that matches no dof (E-GLOB)."""
    joints = [joint for joint in robot.joints if matches_glob(joint.name, glob)]
    dofs_of_joints = [dof.name for joint in joints for dof in joint.dofs]
    if dofs_of_joints:
        text = f"{glob!r} names a joint of several dofs (or several such joints), not one dof"
        log.report("E-GLOB", text, where, f"name one of its dofs: {', '.join(dofs_of_joints)}")
    else:
        report_unmatched(glob, "joint", [dof.name for dof in robot.dofs], where, log)


def report_unmatched(glob: str, kind: str, names: Collection[str], where: str, log: Diagnostics) -> None:
    """Reports a glob that matches none of the names of a kind of thing (E-GLOB)."""
    if not any(matches_glob(name, glob) for name in names):
        log.report_unmatched(
            "E-GLOB", f"no {kind} matches {glob!r}", where, no_match_hint(glob, {f"{kind}s": names}), glob
        )


def actuator_sensors(
    name: str, section: "SensorSection", robot: Robot, actuation: Actuation, log: Diagnostics
) -> Iterator[Sensor]:
    """Yields the sensors of the actuators that an entry of `sensors` names, actuator by actuator. Reports
    E-GLOB if no actuator matches, and E-SENSOR for a wrong unit."""
    glob = section.actuators or "*"
    all_names = [actuator.name for actuator in actuation.actuators]
    names = [actuator_name for actuator_name in all_names if matches_glob(actuator_name, glob)]
    report_unmatched(glob, "actuator", all_names, f"sensors.{name}.actuators", log)
    is_named = names == [glob]
    dofs = {dof.name: dof for dof in robot.dofs}
    dof_of_actuator = {actuator.name: dofs[actuator.dof] for actuator in actuation.actuators}
    for actuator in names:
        for measured in section.measured:
            _check_units(measured, section, dof_of_actuator[actuator], f"sensors.{name}", log)
            yield Sensor(
                _sensor_name(name, "" if is_named else actuator, measured),
                MEASURES["actuator"][measured],
                "actuator",
                actuator,
                noise=section.noise_of(measured),
                cutoff=section.cutoff_of(measured),
            )


def requested_sensors(
    actuation: Actuation, entries: Mapping[str, "ActuatorSection"], log: Diagnostics
) -> Iterator[tuple[str, Sensor]]:
    """Yields the sensors that the entries of `actuators` request, actuator by actuator, each with its
    key.

    Reports an entry that requests only sensors for a dof that nothing drives (E-SENSOR).
    """
    for glob, entry in entries.items():
        # An entry for all dofs may request more sensors than there are actuators.
        needs_actuator = entry.only_measures and (entry.encoder or entry.force) and glob != "*"
        if needs_actuator and not any(matches_glob(actuator.dof, glob) for actuator in actuation.actuators):
            text = f"nothing drives {glob!r}, so there is nothing to measure"
            log.report("E-SENSOR", text, f"actuators.{glob}", "give it a type or a motor too")
    for actuator in actuation.actuators:
        for key, measures in (("encoder", ENCODER_ELEMENTS), ("force", {"force": "actuatorfrc"})):
            requests = [
                (glob, value)
                for glob, entry in entries.items()
                if matches_glob(actuator.dof, glob)
                if (value := getattr(entry, key)) is not None
            ]
            # The last entry that matches decides.
            if requests and requests[-1][1]:
                for measured, kind in measures.items():
                    sensor = Sensor(f"{actuator.name}_{measured}", kind, "actuator", actuator.name)
                    yield f"actuators.{requests[-1][0]}.{key}", sensor
