"""The transmissions, controls and actuators of the source, under the present names and in the present values
of the joints."""

from dataclasses import replace

from linkwright.stages.formats.urdf.transmission_counts import with_counts
from linkwright.stages.formats.urdf.transmissions import with_joints
from linkwright.stages.graph.mechanism import Mechanism
from linkwright.stages.graph.passes.recount_actuators import recounted
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Robot, Sensor, Transmission
from linkwright.stages.robot.text.globs import listed


def with_actuation(robot: Robot, mechanism: Mechanism, log: Diagnostics) -> Robot:
    """The robot with the mechanism's transmissions and controls, as far as their joints are still there."""
    counts = {dof.name: dof.in_mate for dof in robot.dofs}
    controls = tuple(with_counts(text, counts) for text in _controls(mechanism, robot, log))
    return replace(
        robot,
        transmissions=_transmissions(mechanism, robot),
        controls=controls,
        actuators=tuple(recounted(one, counts[one.dof]) for one in mechanism.actuators if one.dof in counts),
        sensors=tuple(one for one in mechanism.sensors if _is_there(robot, one)),
    )


def _is_there(robot: Robot, sensor: Sensor) -> bool:
    """Whether the robot has what a sensor is on, but for actuators, which the export may change."""
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
        replace(one, joint=dof.name, reduction=one.reduction * dof.in_mate.sign)
        for one in mechanism.transmissions
        for dof in dofs.get(one.joint, ())
    )


def _controls(mechanism: Mechanism, robot: Robot, log: Diagnostics) -> tuple[str, ...]:
    """W-URDF-CONTROL for a joint that is gone, or that is several in a URDF."""
    names = {joint.mate.name: joint.name for joint in robot.joints if joint.mate and len(joint.dofs) < 2}
    found = []
    for text in mechanism.controls:
        changed, lost = with_joints(text, names)
        found += [changed] if changed else []
        if lost:
            what = f"a <transmission> or <ros2_control> names {listed(lost)}, which the robot does not have"
            hint = "name a joint of the robot, or remove it"
            log.report("W-URDF-CONTROL", f"{what}: left out", listed(lost), hint)
    return tuple(found)
