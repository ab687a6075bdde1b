"""Sensors of dofs and of actuators, by name or glob."""

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Literal

from linkwright.stages.export.configuration.sensor_section import MEASURES
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Dof, Robot, Sensor
from linkwright.stages.robot.quantity_keys import as_typed, misfit
from linkwright.stages.robot.text.globs import fits, there_are

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.actuator_section import ActuatorSection
    from linkwright.stages.export.configuration.sensor_section import SensorSection

OF_BALLS = {"pos": "ballquat", "vel": "ballangvel"}
"""What is measured of a ball → MuJoCo's element."""

ENCODER = {"pos": "actuatorpos", "vel": "actuatorvel"}


def joint_sensors(name: str, keys: "SensorSection", robot: Robot, log: Diagnostics) -> Iterator[Sensor]:
    """The sensors of the dofs that an entry names, dof by dof. A glob leaves out what a dof does not have."""
    where, glob = f"sensors.{name}.joints", keys.joints or "*"
    dofs = [dof for dof in robot.dofs if fits(dof.name, glob)]
    if not dofs:
        _report_dof(glob, where, robot, log)
        return
    exact = [dof.name for dof in dofs] == [glob]
    for measured in keys.measured:
        lacking = [why for dof in dofs if (why := _why_not(dof, measured))]
        if len(lacking) == len(dofs):
            first = f"{dofs[0].name} {lacking[0]}"
            text = first if exact else f"no joint that {glob!r} matches has {measured}: {first}"
            log.report("E-SENSOR", text, where, f"leave {measured} out of measure, or name another joint")
    for dof in dofs:
        for measured in keys.measured:
            if _why_not(dof, measured):
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
    """E-SENSOR for a length where the dof turns, or an angle where it slides."""
    names: tuple[Literal["noise", "cutoff"], ...] = ("noise", "cutoff")
    for key in names:
        if wrong := misfit(keys.typed(key, measured), dof.kind):
            log.report("E-SENSOR", f"{key} of {measured} of {dof.name}: {wrong}", where, as_typed(dof.kind))


def _why_not(dof: Dof, measured: str) -> str:
    """Why a dof lacks what is to be measured; "" if it has it."""
    if dof.kind == "free":
        return "moves freely: a sensor of type frame measures where its link is"
    if dof.kind == "ball":
        return "" if measured in OF_BALLS else f"is a ball: it has pos and vel, but no {measured}"
    if measured.startswith("limit_") and dof.limits.lower is None and dof.limits.upper is None:
        return f"has no limits, so it has no {measured}"
    return ""


def _report_dof(glob: str, where: str, robot: Robot, log: Diagnostics) -> None:
    of_joint = [dof.name for one in robot.joints if fits(one.name, glob) for dof in one.dofs]
    if of_joint:
        text = f"{glob!r} names a joint of several dofs (or several such joints), not one dof"
        log.report("E-GLOB", text, where, f"name one of its dofs: {', '.join(of_joint)}")
    else:
        report_unmatched(glob, "joint", [dof.name for dof in robot.dofs], where, log)


def report_unmatched(glob: str, kind: str, names: Collection[str], where: str, log: Diagnostics) -> None:
    """E-GLOB where a glob matches none of the names of a kind of thing."""
    if not any(fits(name, glob) for name in names):
        log.unmatched(
            "E-GLOB", f"no {kind} matches {glob!r}", where, there_are(glob, {f"{kind}s": names}), glob
        )


def actuator_sensors(
    name: str, keys: "SensorSection", robot: Robot, actuation: Actuation, log: Diagnostics
) -> Iterator[Sensor]:
    """The sensors of the actuators that an entry names, actuator by actuator."""
    glob = keys.actuators or "*"
    every = [one.name for one in actuation.actuators]
    names = [one for one in every if fits(one, glob)]
    report_unmatched(glob, "actuator", every, f"sensors.{name}.actuators", log)
    exact = names == [glob]
    dofs = {dof.name: dof for dof in robot.dofs}
    driven = {one.name: dofs[one.dof] for one in actuation.actuators}
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
    """The sensors that the entries of `actuators` ask for, actuator by actuator, each with its key.

    E-SENSOR for an entry that asks for nothing else, where nothing drives.
    """
    for glob, keys in entries.items():
        asked = keys.only_measures and (keys.encoder or keys.force) and glob != "*"
        if asked and not any(fits(one.dof, glob) for one in actuation.actuators):
            text = f"nothing drives {glob!r}, so there is nothing to measure"
            log.report("E-SENSOR", text, f"actuators.{glob}", "give it a type or a motor too")
    for one in actuation.actuators:
        for key, measures in (("encoder", ENCODER), ("force", {"force": "actuatorfrc"})):
            said = [
                (glob, value)
                for glob, keys in entries.items()
                if fits(one.dof, glob)
                if (value := getattr(keys, key)) is not None
            ]
            if said and said[-1][1]:
                for measured, kind in measures.items():
                    made = Sensor(f"{one.name}_{measured}", kind, "actuator", one.name)
                    yield f"actuators.{said[-1][0]}.{key}", made
