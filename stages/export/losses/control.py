"""Lists what formats lose of actuators, sensors, planning groups, keyframes, commands of ROS 2, and names."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.losses.joints import free_joints
from linkwright.stages.export.losses.loss import Loss
from linkwright.stages.export.writer import Case
from linkwright.stages.robot.motion.start_pose import HOME

if TYPE_CHECKING:
    from linkwright.stages.export.ros2.control import Ros2Plan


def _merged_links(case: Case[Any]) -> Iterator[str]:
    """Yields a text for each link that the MJCF merges into another body: the link and the body."""
    for link in case.written.mjcf_form.fused:
        body, _ = case.written.as_mjcf.held[link]
        yield f"{link} into {body}"


def _keyframes_except_home(case: Case[Any]) -> list[str]:
    return [keyframe.name for keyframe in case.robot.keyframes if keyframe.name != HOME]


def _renamed_elements(case: Case[Any]) -> list[str]:
    return [
        f"the {kind} {name!r} is {new_name!r}" for kind, name, new_name in case.plan.names.changed_names()
    ]


def _elements_renamed_in_ros2(case: "Case[Ros2Plan]") -> Iterator[str]:
    for kinds, names in case.plan.description.names.renamed.items():
        # The key is a plural: "links" or "joints".
        kind = kinds.removesuffix("s")
        for name, new_name in names.items():
            yield f"the {kind} {name!r} is {new_name!r}"


def _passive_joints(case: "Case[Ros2Plan]") -> Iterator[str]:
    """Yields the joints without a command interface that follow no other joint."""
    for joint in case.plan.control.joints:
        if not joint.commands and not joint.follows:
            yield joint.name


CONTROL_LOSSES = (
    Loss(
        {"mjcf": "I-MJCF-MERGED"},
        _merged_links,
        "links on fixed joints are merged into their parent bodies, and a site marks each of them: {}",
        "robot.json has their poses, under `fused`; export.mjcf.fixed_joints=keep gives each link a body",
    ),
    Loss(
        {"srdf": "I-SRDF-FREE"},
        free_joints,
        "joints of six degrees of freedom are in no planning group, and no pose has their values: {}",
        "MoveIt gets the poses of their links from the node that publishes the joint states",
    ),
    Loss(
        {"srdf": "I-SRDF-LOOP"},
        lambda case: case.plan.loops,
        "MoveIt cannot represent closed loops and plans as if these were open: {}",
        "joints of the loops that nothing drives are passive joints, whose states must be published",
    ),
    Loss(
        {"sdf": "I-SDF-ACTUATOR"},
        lambda case: [actuator.name for actuator in case.written.actuation.actuators],
        "SDF has no actuators, so these are left out: {}",
        "a controller of Gazebo (JointPositionController, ros2_control) can drive their joints",
    ),
    Loss(
        {"sdf": "I-SDF-SENSOR"},
        lambda case: case.plan.sensors.left_out,
        "SDF has no such sensors, so these are left out: {}",
        "Gazebo publishes the states of joints and the poses of links by systems of its own",
    ),
    Loss(
        {"sdf": "I-SDF-TORQUE"},
        lambda case: [sensor.name for sensor in case.plan.sensors.mounted if sensor.is_off_joint_origin],
        "SDF measures torques about the origin of the parent joint; these sensors are elsewhere on their "
        "links, so they give other torques than in the MJCF: {}",
        "subtract (sensor − joint) × force from the SDF's torque; forces are the same",
    ),
    Loss(
        {"sdf": "I-SDF-NAME"},
        _renamed_elements,
        "links, joints and frames share a namespace in an SDF, and some names are reserved there: {}",
        "the other formats keep the names",
    ),
    Loss(
        {"usd": "I-USD-SENSOR"},
        lambda case: [sensor.name for sensor in case.plan.sensing.sensors],
        "USD has no sensors except cameras, so these are left out: {}",
        "Xforms on the links have their poses: add the sensors of Isaac Sim or Newton there",
    ),
    Loss(
        {"usd": "I-USD-KEYFRAME"},
        _keyframes_except_home,
        "a USD has a single pose, which is `home`, so these keyframes are left out: {}",
        "the MJCF has them as keyframes",
    ),
    Loss(
        {"usd": "I-USD-NAME"},
        _renamed_elements,
        "names in a USD consist of ASCII letters, digits and _, and do not begin with a digit: {}",
        "the prim's display name is the original name (displayName)",
    ),
    Loss(
        {"ros2": "I-ROS2-NAME"},
        _elements_renamed_in_ros2,
        "names of links and joints in the ROS package are letters, digits and _, and do not begin with a "
        "digit: {}",
        "the other formats keep the names; robot.json has both, under `ros2`",
    ),
    Loss(
        {"ros2": "I-ROS2-PASSIVE"},
        _passive_joints,
        "nothing drives these joints, so ros2_control has no command interface for them, and mock hardware "
        "leaves them at home: {}",
        "to drive them, add entries to `actuators`",
    ),
    Loss(
        {"ros2": "I-ROS2-FOLLOWER"},
        lambda case: case.plan.control.follower_joints,
        "ros2_control does not command joints that follow others, so their actuators are left out: {}",
        "command the joints that they follow",
    ),
    Loss(
        {"ros2": "I-ROS2-ACTUATOR"},
        lambda case: [f"{joint} ({type_})" for joint, type_ in case.plan.control.effort_fallbacks],
        "ros2_control has no interface for these types of actuators, so the joints are commanded by effort: "
        "{}",
        "choose another type in `actuators`, or add an interface of your own to the ros2_control file",
    ),
    Loss(
        {"ros2": "I-ROS2-MOVEIT"},
        lambda case: case.plan.moveit and not case.plan.control.commanded("position"),
        "no joint is commanded by position, and so no controller follows trajectories: MoveIt plans for the "
        "robot, but moves nothing",
        "set `actuators=position`, or add a controller of your own to moveit_controllers.yaml",
    ),
    Loss(
        {"ros2": "I-ROS2-SENSOR"},
        lambda case: case.plan.control.left_out,
        "ros2_control has no broadcaster for these sensors, or the URDF has no frame at their poses, so they "
        "are left out: {}",
        "add a frame at the sensor's pose (`frames: {add: ...}`); cameras and the like have their own "
        "drivers in ROS",
    ),
    Loss(
        {"ros2": "I-ROS2-CONTROL"},
        lambda case: case.plan.description.root.find("ros2_control") is not None,
        "the URDF already has a <ros2_control>: it stays in the package's URDF, and the xacro uses its "
        "hardware with use_mock_hardware:=false",
        "the interfaces in the xacro are those of `actuators`, else those of the URDF",
    ),
)
