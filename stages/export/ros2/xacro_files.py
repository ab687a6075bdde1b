"""Writes the xacro files of a ROS 2 package: a macro of the robot, one of its ros2_control, and the file that
instantiates them.

A macro puts its prefix before the names of all links, joints, materials and sensors, so that a cell may have
the robot several times.
"""

from collections.abc import Sequence

from linkwright.stages.export.ros2.control import INTERFACES, JOINT, Control, Parameters
from linkwright.stages.export.ros2.description import Description, references, without_control
from linkwright.stages.formats.numbers import TURN, number
from linkwright.stages.formats.xml import Element, element, rooted, to_bytes

XACRO = "http://www.ros.org/wiki/xacro"

MOCK = "mock_components/GenericSystem"
"""Hardware whose state is at once what it is commanded to be."""

ARGUMENTS = (
    ("prefix", ""),
    ("parent", ""),
    ("xyz", "0 0 0"),
    ("rpy", "0 0 0"),
    ("use_ros2_control", "true"),
    ("use_mock_hardware", "true"),
)
"""(name, default) of each argument of the entry file, without the plugin of the hardware."""


def macro(description: Description, name: str, mount: str) -> bytes:
    """Returns the robot as a macro. `mount`: the name of the joint that holds it if it has a parent."""
    robot, _ = without_control(description.root)
    root = _document()
    body = element(root, _xacro("macro"), name=name, params="prefix:='' parent:='' xyz:='0 0 0' rpy:='0 0 0'")
    base = f"${{prefix}}{description.base}"
    mounted = element(body, _xacro("if"), value=f"${{parent not in ('', prefix + '{description.base}')}}")
    joint = element(mounted, "joint", name=f"${{prefix}}{mount}", type="fixed")
    element(joint, "parent", link="${parent}")
    element(joint, "child", link=base)
    element(joint, "origin", xyz="${xyz}", rpy="${rpy}")
    _guard(robot)
    for node, key, _ in list(references(robot)):
        node.set(key, "${prefix}" + node.get(key))
    body.extend(list(robot))
    return to_bytes(root)


def control_macro(control: Control, name: str) -> bytes:
    """Returns the ros2_control of the robot as a macro."""
    root = _document()
    params = (
        f"name:='{name}' prefix:='' use_mock_hardware:=true hardware_plugin:='{_dollars(control.plugin)}'"
    )
    body = element(root, _xacro("macro"), name=f"{name}_ros2_control", params=params)
    top = element(body, "ros2_control", name="${prefix}${name}", type="system")
    _hardware(top, control)
    for joint in control.joints:
        node = element(top, "joint", name=f"${{prefix}}{joint.name}")
        if joint.follows:
            # ROS 2 Humble reads these parameters; newer versions read the <mimic> of the URDF.
            driver, multiplier = joint.follows
            element(node, "param", name="mimic").text = f"${{prefix}}{driver}"
            element(node, "param", name="multiplier").text = multiplier
        _add(node, joint.parameters.get(JOINT, ()))
        for interface in joint.commands:
            command = element(node, "command_interface", name=interface)
            _add(command, joint.parameters.get(interface, ()))
        for interface in joint.states:
            state = element(node, "state_interface", name=interface)
            if interface == "position":
                element(state, "param", name="initial_value").text = number(joint.home, least=TURN)
    for sensor in control.sensors:
        node = element(top, "sensor", name=f"${{prefix}}{sensor.name}")
        for interface in INTERFACES[sensor.kind]:
            state = element(node, "state_interface", name=interface)
            element(state, "param", name="initial_value").text = "1" if interface.endswith(".w") else "0"
        element(node, "param", name="frame_id").text = f"${{prefix}}{sensor.frame}"
    return to_bytes(root)


def entry(robot: str, description: Description, control: Control, name: str, files: tuple[str, str]) -> bytes:
    """Returns the entry file, which a user expands. `files`: the file of the robot's macro, and that of its
    ros2_control."""
    root = _document(name=robot)
    for argument, default in (*ARGUMENTS, ("hardware_plugin", control.plugin)):
        element(root, _xacro("arg"), name=argument, default=_dollars(default))
    for file in files:
        element(root, _xacro("include"), filename=file)
    for argument in ("prefix", "parent"):
        element(root, _xacro("property"), name=argument, value=f"$(arg {argument})")
    parent_exists = element(
        root, _xacro("if"), value=f"${{parent not in ('', prefix + '{description.base}')}}"
    )
    element(parent_exists, "link", name="${parent}")
    _call(root, name, ("prefix", "parent", "xyz", "rpy"))
    if control.joints or control.sensors:
        has_control = element(root, _xacro("if"), value="$(arg use_ros2_control)")
        _call(has_control, f"{name}_ros2_control", ("prefix", "use_mock_hardware", "hardware_plugin"))
    return to_bytes(root)


def _call(above: Element, macro: str, arguments: Sequence[str]) -> None:
    """Writes a call of the macro with the arguments of the file."""
    node = element(above, _xacro(macro))
    for argument in arguments:
        node.set(argument, f"$(arg {argument})")


def _hardware(top: Element, control: Control) -> None:
    hardware = element(top, "hardware")
    mock = element(hardware, _xacro("if"), value="${use_mock_hardware}")
    element(mock, "plugin").text = MOCK
    if control.commanded("velocity") and not control.commanded("effort"):
        # Then commands of speed move the joints, but no controller of efforts may start.
        element(mock, "param", name="calculate_dynamics").text = "true"
    real = element(hardware, _xacro("unless"), value="${use_mock_hardware}")
    text = "hardware_plugin:=... has to name a plugin where use_mock_hardware is false"
    plugin = f"${{hardware_plugin if hardware_plugin else xacro.fatal('{text}')}}"
    element(real, "plugin").text = plugin
    _add(real, control.parameters)


def _add(node: Element, parameters: Parameters) -> None:
    for name, value in parameters:
        element(node, "param", name=_dollars(name)).text = _dollars(value)


def _document(**attributes: str) -> Element:
    return rooted("robot", {"xacro": XACRO}, **attributes)


def _xacro(tag: str) -> str:
    return f"{{{XACRO}}}{tag}"


def _guard(root: Element) -> None:
    """Escapes text that looks like an expression of xacro."""
    for node in root.iter():
        for key, value in node.attrib.items():
            node.set(key, _dollars(value))
        node.text = _dollars(node.text) if node.text else node.text


def _dollars(text: str) -> str:
    return text.replace("${", "$${").replace("$(", "$$(")
