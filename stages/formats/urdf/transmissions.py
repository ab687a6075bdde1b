"""Reads the transmissions of a URDF, of either style, and the joints of its ros2_control."""

from collections.abc import Mapping

from linkwright.stages.formats import xml
from linkwright.stages.formats.urdf.diagnostics import FileDiagnostics
from linkwright.stages.formats.urdf.elements import number
from linkwright.stages.formats.urdf.model import Transmission
from linkwright.stages.formats.xml import Element, tag

REDUCTION_TAGS = ("mechanicalReduction", "mechanical_reduction")
"""Tags of a reduction, by style."""


def transmissions(element: Element, log: FileDiagnostics) -> list[Transmission]:
    """Returns the transmissions of a <transmission>, an entry for each of its joints.

    The older style has the type in an attribute and the reduction next to the joint, the newer both in
    elements of their own. ros2_control has the type in <plugin> and the reduction in the joint.
    """
    name = element.get("name", "")
    kind = element.get("type") or _text(element, "type") or _text(element, "plugin")
    actuators = [node for node in element if tag(node) == "actuator"]
    entries = []
    for index, joint in enumerate(node for node in element if tag(node) == "joint"):
        actuator = actuators[min(index, len(actuators) - 1)] if actuators else element
        interfaces = _interfaces(joint) or _interfaces(actuator)
        reduction = _reduction((joint, actuator, element), log)
        entries.append(Transmission(name, joint.get("name", ""), kind, reduction, interfaces))
    return entries


def controlled(element: Element, log: FileDiagnostics) -> list[Transmission]:
    """Returns the transmissions of a <ros2_control>: its joints that take commands, and its
    <transmission>s."""
    hardware = next((node for node in element if tag(node) == "hardware"), None)
    plugin = "" if hardware is None else _text(hardware, "plugin")
    entries = []
    for node in element:
        if tag(node) == "joint":
            commands = [inner.get("name", "") for inner in node if tag(inner) == "command_interface"]
            if commands:
                name = element.get("name", "")
                entries.append(Transmission(name, node.get("name", ""), plugin, 1.0, tuple(commands)))
        elif tag(node) == "transmission":
            entries += transmissions(node, log)
    return entries


def rotors(element: Element, log: FileDiagnostics) -> dict[str, float]:
    """Returns the reflected inertia of each joint's rotor [kg m² or kg], if a <transmission> has it as Drake
    does: the inertia of the rotor times the square of the gear's ratio. A negative inertia is left out
    (reports E-URDF-NUMBER)."""
    joints = [node.get("name", "") for node in element if tag(node) == "joint"]
    actuators = [node for node in element if tag(node) == "actuator"]
    inertia_by_joint = {}
    for joint, actuator in zip(joints, actuators, strict=False):
        parts = {tag(node).removeprefix("drake:"): node for node in actuator}
        inertia = number(parts["rotor_inertia"], "value", log) if "rotor_inertia" in parts else None
        ratio = number(parts["gear_ratio"], "value", log) if "gear_ratio" in parts else None
        if inertia is not None and inertia < 0:
            text = f'<{tag(parts["rotor_inertia"])} value="{inertia:g}">: must not be negative'
            log.report("E-URDF-NUMBER", parts["rotor_inertia"], text)
        elif inertia is not None:
            inertia_by_joint[joint] = inertia * (1.0 if ratio is None else ratio) ** 2
    return inertia_by_joint


def with_joints(text: str, names: Mapping[str, str]) -> tuple[str, tuple[str, ...]]:
    """Returns the text of a <transmission> or <ros2_control> with other names of joints, and the joints in it
    that do not exist, sorted.

    `names`: old name of an existing joint → new name. A missing joint is left out of a <ros2_control>, and so
    is a transmission that has such a joint; the text is "" if nothing is left.
    """
    root = xml.parse(text.encode())
    missing_joints: set[str] = set()
    for element in [node for node in root.iter() if tag(node) == "joint"]:
        name = element.get("name", "")
        if name in names:
            element.set("name", names[name])
            for mimic in (node for node in element if tag(node) == "param" and node.get("name") == "mimic"):
                followed = (mimic.text or "").strip()
                mimic.text = names.get(followed, followed)
            continue
        missing_joints.add(name)
        holder = element.getparent() if tag(element.getparent()) == "transmission" else element
        if holder is root:
            return "", tuple(sorted(missing_joints))
        if holder.getparent() is not None:
            holder.getparent().remove(holder)
    return xml.to_text(root), tuple(sorted(missing_joints))


def _text(element: Element, name: str) -> str:
    """Returns the text of the first child of that name, or ""."""
    return next(((node.text or "").strip() for node in element if tag(node) == name), "")


def _interfaces(element: Element) -> tuple[str, ...]:
    """Returns the hardware interfaces in a joint or an actuator."""
    return tuple((node.text or "").strip() for node in element if tag(node) == "hardwareInterface")


def _reduction(places: tuple[Element, ...], log: FileDiagnostics) -> float:
    """Returns the first reduction in these elements; 1 without any, and if it is 0 or not a number (reports
    E-URDF-NUMBER)."""
    for place in places:
        for node in place:
            if tag(node) in REDUCTION_TAGS:
                # `number` reads attributes.
                node.set("value", (node.text or "").strip())
                return number(node, "value", log) or 1.0
    return 1.0
