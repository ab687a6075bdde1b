"""Writes the xacro files of a ROS 2 package: a macro of the robot, one of its ros2_control, and the file that
instantiates them.

A macro puts its prefix before the names of all links, joints, materials and sensors, so that a cell may have
the robot several times.
"""

from collections.abc import Sequence

from linkwright.stages.export.ros2.control import INTERFACES, JOINT_KEY, Control, Parameters
from linkwright.stages.export.ros2.description import Description, references, without_control
from linkwright.stages.formats.numbers import TURN, number
from linkwright.stages.formats.xml import Element, element, rooted, to_bytes

XACRO_NAMESPACE = "http://www.ros.org/wiki/xacro"

MOCK_PLUGIN = "mock_components/GenericSystem"
"""Plugin of mock hardware, whose state is at once the commanded state."""

ARGUMENTS = (
    ("prefix", ""),
    ("parent", ""),
    ("xyz", "0 0 0"),
    ("rpy", "0 0 0"),
    ("use_ros2_control", "true"),
    ("use_mock_hardware", "true"),
)
"""(name, default) of each argument of the entry file, except `hardware_plugin`."""


def robot_macro(description: Description, name: str, mount: str) -> bytes:
    """Returns the file with the robot as a macro. `name`: the name of the macro; `mount`: the name of the
    joint that fixes the robot to its parent, if it has a parent."""
    robot, _ = without_control(description.root)
    root = _document()
    body = element(
        root, _xacro_tag("macro"), name=name, params="prefix:='' parent:='' xyz:='0 0 0' rpy:='0 0 0'"
    )
    base = f"${{prefix}}{description.base}"
    mounted = element(body, _xacro_tag("if"), value=f"${{parent not in ('', prefix + '{description.base}')}}")
    joint = element(mounted, "joint", name=f"${{prefix}}{mount}", type="fixed")
    element(joint, "parent", link="${parent}")
    element(joint, "child", link=base)
    element(joint, "origin", xyz="${xyz}", rpy="${rpy}")
    _escape_expressions(robot)
    for node, key, _ in list(references(robot)):
        node.set(key, "${prefix}" + node.get(key))
    body.extend(list(robot))
    return to_bytes(root)


def control_macro(control: Control, name: str) -> bytes:
    """Returns the file with the ros2_control of the robot as a macro. `name`: the name of the robot's
    macro."""
    root = _document()
    params = (
        f"name:='{name}' prefix:='' use_mock_hardware:=true hardware_plugin:='{_escaped(control.plugin)}'"
    )
    body = element(root, _xacro_tag("macro"), name=f"{name}_ros2_control", params=params)
    top = element(body, "ros2_control", name="${prefix}${name}", type="system")
    _write_hardware(top, control)
    for joint in control.joints:
        node = element(top, "joint", name=f"${{prefix}}{joint.name}")
        if joint.follows:
            # ROS 2 Humble reads these parameters; newer versions read the <mimic> of the URDF.
            driver, multiplier = joint.follows
            element(node, "param", name="mimic").text = f"${{prefix}}{driver}"
            element(node, "param", name="multiplier").text = multiplier
        _write_parameters(node, joint.parameters.get(JOINT_KEY, ()))
        for interface in joint.commands:
            command = element(node, "command_interface", name=interface)
            _write_parameters(command, joint.parameters.get(interface, ()))
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


def entry_file(
    robot: str, description: Description, control: Control, name: str, files: tuple[str, str]
) -> bytes:
    """Returns the entry file, which a user expands. `name`: the name of the robot's macro; `files`: the file
    of that macro, and the file of its ros2_control."""
    root = _document(name=robot)
    for argument, default in (*ARGUMENTS, ("hardware_plugin", control.plugin)):
        element(root, _xacro_tag("arg"), name=argument, default=_escaped(default))
    for file in files:
        element(root, _xacro_tag("include"), filename=file)
    for argument in ("prefix", "parent"):
        element(root, _xacro_tag("property"), name=argument, value=f"$(arg {argument})")
    parent_exists = element(
        root, _xacro_tag("if"), value=f"${{parent not in ('', prefix + '{description.base}')}}"
    )
    element(parent_exists, "link", name="${parent}")
    _write_call(root, name, ("prefix", "parent", "xyz", "rpy"))
    if control.joints or control.sensors:
        has_control = element(root, _xacro_tag("if"), value="$(arg use_ros2_control)")
        _write_call(has_control, f"{name}_ros2_control", ("prefix", "use_mock_hardware", "hardware_plugin"))
    return to_bytes(root)


def _write_call(parent: Element, macro: str, arguments: Sequence[str]) -> None:
    """Writes a call of a macro, with these arguments of the file."""
    node = element(parent, _xacro_tag(macro))
    for argument in arguments:
        node.set(argument, f"$(arg {argument})")


def _write_hardware(top: Element, control: Control) -> None:
    """Writes the hardware: mock hardware, or the plugin of the argument `hardware_plugin`."""
    hardware = element(top, "hardware")
    mock = element(hardware, _xacro_tag("if"), value="${use_mock_hardware}")
    element(mock, "plugin").text = MOCK_PLUGIN
    if control.commanded("velocity") and not control.commanded("effort"):
        # With this parameter, velocity commands move the joints of mock hardware, but no controller of
        # efforts can start.
        element(mock, "param", name="calculate_dynamics").text = "true"
    real = element(hardware, _xacro_tag("unless"), value="${use_mock_hardware}")
    text = "hardware_plugin:=... has to name a plugin where use_mock_hardware is false"
    plugin = f"${{hardware_plugin if hardware_plugin else xacro.fatal('{text}')}}"
    element(real, "plugin").text = plugin
    _write_parameters(real, control.parameters)


def _write_parameters(node: Element, parameters: Parameters) -> None:
    """Writes a <param> for each parameter."""
    for name, value in parameters:
        element(node, "param", name=_escaped(name)).text = _escaped(value)


def _document(**attributes: str) -> Element:
    """Returns the root element of a xacro file."""
    return rooted("robot", {"xacro": XACRO_NAMESPACE}, **attributes)


def _xacro_tag(tag: str) -> str:
    """Returns a tag in the namespace of xacro."""
    return f"{{{XACRO_NAMESPACE}}}{tag}"


def _escape_expressions(root: Element) -> None:
    """Escapes the attributes and texts that xacro would read as expressions."""
    for node in root.iter():
        for key, value in node.attrib.items():
            node.set(key, _escaped(value))
        node.text = _escaped(node.text) if node.text else node.text


def _escaped(text: str) -> str:
    """Returns a text in which xacro finds no expression."""
    return text.replace("${", "$${").replace("$(", "$$(")
