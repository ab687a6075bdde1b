"""Changes the values in a <transmission> or <ros2_control> whose joints get another zero or sign."""

from collections.abc import Mapping

from linkwright.stages.formats import xml
from linkwright.stages.formats.urdf.transmissions import REDUCTION_TAGS
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.model.dofs import AS_THE_MATE, MateValue


def with_counts(text: str, counts: Mapping[str, MateValue]) -> str:
    """Returns the text with the values of its joints counted as in `counts`, by name of joint.

    In a <ros2_control>, the ranges and initial values of interfaces change: positions follow zero and sign,
    speeds and forces the sign. The reduction of a transmission follows the sign, and the offset of the joint
    both: q = actuator / reduction + offset (ros2_control, "Transmission Interface").
    """
    if all(mate_value == AS_THE_MATE for mate_value in counts.values()):
        return text
    root = xml.parse(text.encode())
    for joint in [node for node in root.iter() if tag(node) == "joint"]:
        mate_value = counts.get(joint.get("name", ""), AS_THE_MATE)
        if mate_value == AS_THE_MATE:
            continue
        holder = joint.getparent()
        if holder is not None and tag(holder) == "transmission":
            _recount_transmission(joint, root, mate_value)
        else:
            for interface in joint:
                _recount_interface(interface, mate_value)
    return xml.to_text(root)


def _recount_interface(interface: Element, mate_value: MateValue) -> None:
    """Changes the range and the initial value of a command or state interface."""
    values = {node.get("name"): node for node in interface if tag(node) == "param"}
    if interface.get("name") != "position":
        # Speeds and forces have no zero to choose.
        mate_value = MateValue(mate_value.sign)
    if "initial_value" in values:
        _change(values["initial_value"], mate_value)
    ends = [values[name] for name in ("min", "max") if name in values]
    for end in ends:
        _change(end, mate_value)
    # With the other sign the lower end is the upper one.
    if mate_value.sign < 0:
        for name, end in (("max", values.get("min")), ("min", values.get("max"))):
            if end is not None:
                end.set("name", name)


def _recount_transmission(joint: Element, root: Element, mate_value: MateValue) -> None:
    """Changes the reduction and the offset of a joint of a <transmission>. `root`: the element of the whole
    text."""
    if mate_value.sign < 0:
        _reverse_reduction(joint)
    offset = next((node for node in joint if tag(node) == "offset"), None)
    if offset is not None:
        _change(offset, mate_value)
    elif tag(root) == "ros2_control" and mate_value.to_mate(0.0):
        xml.element(joint, "offset").text = _text(mate_value.from_mate(0.0))


def _reverse_reduction(joint: Element) -> None:
    """Changes the sign of the reduction between a joint of a <transmission> and its actuator.

    A transmission of a single joint has the reduction in the joint, in the actuator or next to them. With
    several joints, the reduction of an actuator is not that of a joint, but comes in addition
    (transmission_interface, "DifferentialTransmission"): so only the joint's own changes, by default 1.
    """
    transmission = joint.getparent()
    places = [joint]
    if sum(tag(node) == "joint" for node in transmission) == 1:
        places += [*(node for node in transmission if tag(node) == "actuator"), transmission]
    reduction = next((node for place in places for node in place if tag(node) in REDUCTION_TAGS), None)
    if reduction is None:
        reduction = xml.element(joint, "mechanical_reduction")
        reduction.text = "1"
    _change(reduction, MateValue(-1))


def _change(element: Element, mate_value: MateValue) -> None:
    """Counts the number in an element as `mate_value` says."""
    try:
        value = float((element.text or "").strip())
    except ValueError:
        # A placeholder of the user's stays.
        return
    element.text = _text(mate_value.from_mate(value))


def _text(value: float) -> str:
    return f"{value:.12g}"
