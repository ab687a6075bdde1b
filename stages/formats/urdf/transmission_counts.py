"""Values in a <transmission> or <ros2_control> whose joints are counted anew."""

from collections.abc import Mapping

from linkwright.stages.formats import xml
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.model.dofs import AS_THE_MATE, MateValue

REDUCTIONS = ("mechanicalReduction", "mechanical_reduction")


def with_counts(text: str, counts: Mapping[str, MateValue]) -> str:
    """The text with the values of its joints counted as `counts` has them, by name of joint.

    In a <ros2_control> the ranges and initial values of interfaces: those of positions follow zero and sign,
    those of speeds and forces the sign. The reduction of a transmission follows the sign, and the offset of
    the joint both: q = actuator / reduction + offset (ros2_control, "Transmission Interface").
    """
    if all(own == AS_THE_MATE for own in counts.values()):
        return text
    root = xml.parse(text.encode())
    for joint in [one for one in root.iter() if tag(one) == "joint"]:
        own = counts.get(joint.get("name", ""), AS_THE_MATE)
        if own == AS_THE_MATE:
            continue
        holder = joint.getparent()
        if root is joint or (holder is not None and tag(holder) == "transmission"):
            _recount_transmission(joint, root, own)
        else:
            for interface in joint:
                _recount_interface(interface, own)
    return xml.to_text(root)


def _recount_interface(interface: Element, own: MateValue) -> None:
    values = {one.get("name"): one for one in interface if tag(one) == "param"}
    of_position = interface.get("name") == "position"
    if not of_position:
        own = MateValue(own.sign)
    if "initial_value" in values:
        _change(values["initial_value"], own)
    ends = [values[name] for name in ("min", "max") if name in values]
    for end in ends:
        _change(end, own)
    if own.sign < 0:
        for name, end in (("max", values.get("min")), ("min", values.get("max"))):
            if end is not None:
                end.set("name", name)


def _recount_transmission(joint: Element, root: Element, own: MateValue) -> None:
    holder = joint.getparent()
    every = [joint] if holder is None else [joint, *(one for one in holder if tag(one) == "actuator")]
    found = next((one for place in every for one in place if tag(one) in REDUCTIONS), None)
    if own.sign < 0:
        if found is None:
            found = xml.element(joint, "mechanical_reduction")
            found.text = "1"
        _change(found, MateValue(-1))
    offset = next((one for one in joint if tag(one) == "offset"), None)
    if offset is not None:
        _change(offset, own)
    elif tag(root) == "ros2_control" and own.of(0.0):
        xml.element(joint, "offset").text = _text(own.inverse(0.0))


def _change(element: Element, own: MateValue) -> None:
    try:
        value = float((element.text or "").strip())
    except ValueError:  # a placeholder of the user's, which stays
        return
    element.text = _text(own.inverse(value))


def _text(value: float) -> str:
    return f"{value:.12g}"
