"""Reports what a ROS 2 package has otherwise, or does not have."""

from collections.abc import Iterator

from linkwright.stages.export.ros2.control import OTHERS, Control
from linkwright.stages.export.ros2.names import RosNames
from linkwright.stages.robot.errors import Diagnostic


def unsupported(
    names: RosNames, control: Control, own_control: bool, place: str, moveit: bool
) -> Iterator[Diagnostic]:
    """A diagnostic for each kind of difference. `own_control`: whether the URDF itself has a <ros2_control>;
    `place`: the folder of the package; `moveit`: whether MoveIt has one beside it."""
    renamed = [
        f"the {kind[:-1]} {name!r} is {own!r}"
        for kind, table in names.renamed.items()
        for name, own in table.items()
    ]
    if renamed:
        yield Diagnostic(
            "I-ROS2-NAME",
            "names of links and joints in the ROS package are letters, digits and _, and do not begin with a "
            "digit: " + ", ".join(renamed),
            place,
            "the other formats keep the names; robot.json has both, under ros2",
        )
    yield from _commands(control, place, moveit)
    if control.left_out:
        yield Diagnostic(
            "I-ROS2-SENSOR",
            "ros2_control has no broadcaster for these sensors, or they are at no frame of the URDF, so they "
            f"are left out: {', '.join(control.left_out)}",
            place,
            "put a frame where the sensor is (`frames: {add: ...}`); cameras and the like have drivers of "
            "their own in ROS",
        )
    if own_control:
        yield Diagnostic(
            "I-ROS2-CONTROL",
            "the URDF has a <ros2_control> of its own: it stays in the package's URDF, and its hardware is "
            "what the xacro uses with use_mock_hardware:=false",
            place,
            "the interfaces in the xacro are those of `actuators`, else those of the URDF",
        )


def _commands(control: Control, place: str, moveit: bool) -> Iterator[Diagnostic]:
    """What is not commanded, or otherwise than it is driven."""
    passive = [one.name for one in control.joints if not one.commands and not one.follows]
    if passive:
        yield Diagnostic(
            "I-ROS2-PASSIVE",
            "nothing drives these joints, so ros2_control has no command interface of them, and mock "
            f"hardware leaves them at home: {', '.join(passive)}",
            place,
            "`actuators` says what drives a joint",
        )
    if control.held_back:
        yield Diagnostic(
            "I-ROS2-FOLLOWER",
            "ros2_control commands no joints that follow others, so their actuators are left out: "
            + ", ".join(control.held_back),
            place,
            "command the joints that they follow",
        )
    if control.by_effort:
        yield Diagnostic(
            "I-ROS2-ACTUATOR",
            "ros2_control has no interface for these types of actuators, so the joints are commanded by "
            f"{OTHERS}: " + ", ".join(f"{joint} ({kind})" for joint, kind in control.by_effort),
            place,
            "another type of `actuators`, or an interface of your own in the ros2_control file",
        )
    if moveit and not control.commanded("position"):
        yield Diagnostic(
            "I-ROS2-MOVEIT",
            "no joint is commanded by position, and so no controller follows trajectories: MoveIt plans for "
            "the robot, but moves nothing",
            place,
            "`actuators=position`, or a controller of your own in moveit_controllers.yaml",
        )
