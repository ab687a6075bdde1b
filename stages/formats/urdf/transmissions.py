"""The transmissions of a URDF, of either style, and the joints of its ros2_control."""

from collections.abc import Mapping

from linkwright.stages.formats import xml
from linkwright.stages.formats.urdf.diagnostics import FileDiagnostics
from linkwright.stages.formats.urdf.elements import number
from linkwright.stages.formats.urdf.model import Transmission
from linkwright.stages.formats.xml import Element, tag


def transmissions(element: Element, log: FileDiagnostics) -> list[Transmission]:
    """A <transmission>: one for each of its joints.

    The older style has the type in an attribute and the reduction beside the joint, the newer both in
    elements of their own. ros2_control has the type in <plugin> and the reduction in the joint.
    """
    name = element.get("name", "")
    kind = element.get("type") or _text(element, "type") or _text(element, "plugin")
    actuators = [one for one in element if tag(one) == "actuator"]
    found = []
    for index, joint in enumerate(one for one in element if tag(one) == "joint"):
        actuator = actuators[min(index, len(actuators) - 1)] if actuators else element
        interfaces = _interfaces(joint) or _interfaces(actuator)
        reduction = _reduction((joint, actuator, element), log)
        found.append(Transmission(name, joint.get("name", ""), kind, reduction, interfaces))
    return found


def controlled(element: Element, log: FileDiagnostics) -> list[Transmission]:
    """A <ros2_control>: its joints that take commands, and its transmissions."""
    hardware = next((one for one in element if tag(one) == "hardware"), None)
    plugin = "" if hardware is None else _text(hardware, "plugin")
    found = []
    for one in element:
        if tag(one) == "joint":
            commands = [each.get("name", "") for each in one if tag(each) == "command_interface"]
            if commands:
                name = element.get("name", "")
                found.append(Transmission(name, one.get("name", ""), plugin, 1.0, tuple(commands)))
        elif tag(one) == "transmission":
            found += transmissions(one, log)
    return found


def rotors(element: Element, log: FileDiagnostics) -> dict[str, float]:
    """The inertia of each joint's rotor as the joint feels it [kg m² or kg], where a <transmission> has it
    as Drake does: that of the rotor times the square of the gear's ratio."""
    joints = [one.get("name", "") for one in element if tag(one) == "joint"]
    actuators = [one for one in element if tag(one) == "actuator"]
    found = {}
    for joint, actuator in zip(joints, actuators, strict=False):
        parts = {tag(one).removeprefix("drake:"): one for one in actuator}
        inertia = number(parts["rotor_inertia"], "value", log) if "rotor_inertia" in parts else None
        ratio = number(parts["gear_ratio"], "value", log) if "gear_ratio" in parts else None
        if inertia is not None:
            found[joint] = inertia * (1.0 if ratio is None else ratio) ** 2
    return found


def with_joints(text: str, names: Mapping[str, str]) -> tuple[str, tuple[str, ...]]:
    """The text of a <transmission> or <ros2_control> with joints called otherwise, and those that it names
    and that are not there, sorted. `names`: those that are there, new by old.

    A joint that is not there is left out of a <ros2_control>, and so is a transmission that has one: the
    text is "" where that is all.
    """
    root = xml.parse(text.encode())
    lost: set[str] = set()
    for element in [one for one in root.iter() if tag(one) == "joint"]:
        name = element.get("name", "")
        if name in names:
            element.set("name", names[name])
            for mimic in (one for one in element if tag(one) == "param" and one.get("name") == "mimic"):
                followed = (mimic.text or "").strip()
                mimic.text = names.get(followed, followed)
            continue
        lost.add(name)
        holder = element.getparent() if tag(element.getparent()) == "transmission" else element
        if holder is root:
            return "", tuple(sorted(lost))
        if holder.getparent() is not None:
            holder.getparent().remove(holder)
    return xml.to_text(root), tuple(sorted(lost))


def _text(element: Element, name: str) -> str:
    """The text of the first child of that name, "" without one."""
    return next(((one.text or "").strip() for one in element if tag(one) == name), "")


def _interfaces(element: Element) -> tuple[str, ...]:
    return tuple((one.text or "").strip() for one in element if tag(one) == "hardwareInterface")


def _reduction(places: tuple[Element, ...], log: FileDiagnostics) -> float:
    """The reduction in the first of these elements that has one; 1 without any."""
    for place in places:
        for one in place:
            if tag(one) in ("mechanicalReduction", "mechanical_reduction"):
                one.set("value", (one.text or "").strip())
                return number(one, "value", log) or 1.0
    return 1.0
