"""Lists losses of control: actuators, sensors, planning groups, commands of ROS 2, and names."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.losses.joints import free_joints
from linkwright.stages.export.losses.loss import Loss
from linkwright.stages.export.writer import Case
from linkwright.stages.robot.motion.start_pose import HOME

if TYPE_CHECKING:
    from linkwright.stages.export.ros2.control import Ros2Plan


def _mjcf_merged(case: Case[Any]) -> Iterator[str]:
    for link in case.written.mjcf_form.fused:
        yield f"{link} into {case.written.as_mjcf.held[link][0]}"


def _other_keyframes(case: Case[Any]) -> list[str]:
    return [keyframe.name for keyframe in case.robot.keyframes if keyframe.name != HOME]


def _renamed(case: Case[Any]) -> list[str]:
    return [f"the {kind} {name!r} is {new_name!r}" for kind, name, new_name in case.plan.names.changed]


def _ros2_renamed(case: "Case[Ros2Plan]") -> Iterator[str]:
    for kind, names in case.plan.description.names.renamed.items():
        for name, new_name in names.items():
            yield f"the {kind[:-1]} {name!r} is {new_name!r}"


def _passive(case: "Case[Ros2Plan]") -> Iterator[str]:
    for joint in case.plan.control.joints:
        if not joint.commands and not joint.follows:
            yield joint.name


CONTROL = (
    Loss(
        {"mjcf": "I-MJCF-MERGED"},
        _mjcf_merged,
        "links on fixed joints are sites of the bodies above them: {}",
        "robot.json has the place of each, under fused; export.mjcf.fixed_joints=keep gives each a body",
    ),
    Loss(
        {"srdf": "I-SRDF-FREE"},
        free_joints,
        "no group moves a joint of six degrees of freedom, and no pose has its value: {}",
        "MoveIt takes the poses of these links from the node that publishes their states",
    ),
    Loss(
        {"srdf": "I-SRDF-LOOP"},
        lambda case: case.plan.loops,
        "MoveIt knows no closed loops and plans as if these were open: {}",
        "joints in them that nothing drives are passive joints, whose states must be published",
    ),
    Loss(
        {"sdf": "I-SDF-ACTUATOR"},
        lambda case: [actuator.name for actuator in case.written.actuation.actuators],
        "SDF has no actuators, so these are left out: {}",
        "a controller of Gazebo (JointPositionController, ros2_control) drives its joints",
    ),
    Loss(
        {"sdf": "I-SDF-SENSOR"},
        lambda case: case.plan.sensors.left_out,
        "SDF has no such sensors, so these are left out: {}",
        "Gazebo publishes the states of joints and the poses of links by systems of its own",
    ),
    Loss(
        {"sdf": "I-SDF-TORQUE"},
        lambda case: [sensor.name for sensor in case.plan.sensors.mounted if sensor.aside],
        "SDF measures torques about the origin of the joint above, in the axes of the sensor, so these "
        "sensors, which are elsewhere on their links, give other torques than in the MJCF: {}",
        "subtract (sensor − joint) × force from the SDF's torque; forces are the same",
    ),
    Loss(
        {"sdf": "I-SDF-NAME"},
        _renamed,
        "links, joints and frames share one space of names in an SDF, and some names are reserved there: {}",
        "the other formats keep the names",
    ),
    Loss(
        {"usd": "I-USD-SENSOR"},
        lambda case: [sensor.name for sensor in case.plan.sensing.sensors],
        "USD has no sensors except cameras, so these are left out: {}",
        "Xforms on the links mark their poses: add the sensors of Isaac Sim or Newton there",
    ),
    Loss(
        {"usd": "I-USD-KEYFRAME"},
        _other_keyframes,
        "a USD has one pose, which is `home`, so these are left out: {}",
        "the MJCF has them as keyframes",
    ),
    Loss(
        {"usd": "I-USD-NAME"},
        _renamed,
        "names in a USD consist of ASCII letters, digits and _, and do not begin with a digit: {}",
        "the prim's display name is the original name (displayName)",
    ),
    Loss(
        {"ros2": "I-ROS2-NAME"},
        _ros2_renamed,
        "names of links and joints in the ROS package are letters, digits and _, and do not begin with a "
        "digit: {}",
        "the other formats keep the names; robot.json has both, under ros2",
    ),
    Loss(
        {"ros2": "I-ROS2-PASSIVE"},
        _passive,
        "nothing drives these joints, so ros2_control has no command interface for them, and mock hardware "
        "leaves them at home: {}",
        "`actuators` says what drives a joint",
    ),
    Loss(
        {"ros2": "I-ROS2-FOLLOWER"},
        lambda case: case.plan.control.held_back,
        "ros2_control does not command joints that follow others, so their actuators are left out: {}",
        "command the joints that they follow",
    ),
    Loss(
        {"ros2": "I-ROS2-ACTUATOR"},
        lambda case: [f"{joint} ({kind})" for joint, kind in case.plan.control.by_effort],
        "ros2_control has no interface for these types of actuators, so the joints are commanded by effort: "
        "{}",
        "another type of `actuators`, or an interface of your own in the ros2_control file",
    ),
    Loss(
        {"ros2": "I-ROS2-MOVEIT"},
        lambda case: case.plan.moveit and not case.plan.control.commanded("position"),
        "no joint is commanded by position, and so no controller follows trajectories: MoveIt plans for the "
        "robot, but moves nothing",
        "`actuators=position`, or a controller of your own in moveit_controllers.yaml",
    ),
    Loss(
        {"ros2": "I-ROS2-SENSOR"},
        lambda case: case.plan.control.left_out,
        "ros2_control has no broadcaster for these sensors, or they are at no frame of the URDF, so they are "
        "left out: {}",
        "put a frame where the sensor is (`frames: {add: ...}`); cameras and the like have drivers of their "
        "own in ROS",
    ),
    Loss(
        {"ros2": "I-ROS2-CONTROL"},
        lambda case: case.plan.description.root.find("ros2_control") is not None,
        "the URDF has a <ros2_control> of its own: it stays in the package's URDF, and its hardware is what "
        "the xacro uses with use_mock_hardware:=false",
        "the interfaces in the xacro are those of `actuators`, else those of the URDF",
    ),
)
