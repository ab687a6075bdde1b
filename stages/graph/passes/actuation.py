"""Carries over the source's transmissions, controls and actuators, with the robot's names and joint
values."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from linkwright.stages.formats.urdf.transmission_counts import with_counts
from linkwright.stages.formats.urdf.transmissions import with_joints
from linkwright.stages.graph.mechanism import Mechanism
from linkwright.stages.graph.passes.recount_actuators import recount_actuator
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Robot, Sensor, Transmission
from linkwright.stages.robot.text.globs import name_list

SUBTREE_SENSORS = ("force", "torque", "subtreecom", "subtreelinvel", "subtreeangmom")
"""Types of sensors that measure the bodies below their body, or the force between it and its parent."""


def with_actuation(robot: Robot, mechanism: Mechanism, log: Diagnostics) -> Robot:
    """Returns the robot with the mechanism's transmissions, controls, actuators and sensors, as far as their
    objects are still in the robot."""
    mate_values = {dof.name: dof.mate_value for dof in robot.dofs}
    sensors = [sensor for sensor in mechanism.sensors if _has_objects(robot, sensor)]
    controls = tuple(with_counts(text, mate_values) for text in _controls(mechanism, robot, log))
    return replace(
        robot,
        transmissions=_transmissions(mechanism, robot),
        controls=controls,
        actuators=tuple(
            recount_actuator(actuator, mate_values[actuator.dof])
            for actuator in mechanism.actuators
            if actuator.dof in mate_values
        ),
        sensors=tuple(_valid_sensors(sensors, robot, mechanism, log)),
    )


def _valid_sensors(
    sensors: Sequence[Sensor], robot: Robot, mechanism: Mechanism, log: Diagnostics
) -> Iterator[Sensor]:
    """Yields the sensors that measure the same as in the source. Reports W-MJCF-LEFT for the others."""
    turned_links = _turned_links(robot, mechanism)
    link_of_target = {frame.name: frame.link for frame in robot.frames} | {
        link.name: link.name for link in robot.links
    }
    lost_names = []
    for sensor in sensors:
        if sensor.type in SUBTREE_SENSORS and link_of_target.get(sensor.name_of_target) in turned_links:
            lost_names.append(sensor.name)
        else:
            yield sensor
    if lost_names:
        names = name_list(lost_names)
        text = f"sensors left out: {names}, since other bodies are above and below theirs than in the source"
        hint = "leave root.select at auto, or add them in `sensors`"
        log.report("W-MJCF-LEFT", text, robot.root.name, hint)


def _turned_links(robot: Robot, mechanism: Mechanism) -> set[str]:
    """Returns the links that have another parent than in the source: those between the source's root and that
    of the robot."""
    if mechanism.root is None:
        return set()
    # Joints that the source does not have, those of added links, leave all that is below them as it is.
    parents = {joint.child: joint.parent for joint in robot.joints if joint.mate is not None}
    path = [mechanism.bodies[mechanism.root].name]
    while path[-1] in parents:
        path.append(parents[path[-1]])
    return set(path) if len(path) > 1 else set()


def _has_objects(robot: Robot, sensor: Sensor) -> bool:
    """Tells whether the robot has the objects of a sensor; actuators, which the export may change, are not
    checked."""
    names = {
        "joint": {dof.name for dof in robot.dofs},
        "site": {frame.name for frame in robot.frames},
        "body": {link.name for link in robot.links},
    }
    names["xbody"] = names["body"]
    ends = (sensor.target, sensor.name_of_target), (sensor.relative_to, sensor.name_of_relative)
    return all(name in names[kind] for kind, name in ends if kind in names)


def _transmissions(mechanism: Mechanism, robot: Robot) -> tuple[Transmission, ...]:
    dofs = {joint.mate.name: joint.dofs[:1] for joint in robot.joints if joint.mate}
    return tuple(
        replace(transmission, joint=dof.name, reduction=transmission.reduction * dof.mate_value.sign)
        for transmission in mechanism.transmissions
        for dof in dofs.get(transmission.joint, ())
    )


def _controls(mechanism: Mechanism, robot: Robot, log: Diagnostics) -> tuple[str, ...]:
    """Returns the control elements with the joints' present names. Reports W-URDF-CONTROL for a joint that
    the robot no longer has, or that is several joints in a URDF."""
    names = {joint.mate.name: joint.name for joint in robot.joints if joint.mate and len(joint.dofs) < 2}
    controls = []
    for text in mechanism.controls:
        renamed_text, lost_joints = with_joints(text, names)
        controls += [renamed_text] if renamed_text else []
        if lost_joints:
            message = f"a <transmission> or <ros2_control> names {name_list(lost_joints)}, "
            message += "which the robot does not have"
            hint = "name a joint of the robot, or remove it"
            log.report("W-URDF-CONTROL", f"{message}: left out", name_list(lost_joints), hint)
    return tuple(controls)
