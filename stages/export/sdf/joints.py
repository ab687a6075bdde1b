"""Writes the joints of an SDF: pose, axis, limits, damping, and the joint that they follow."""

from linkwright.stages.export.sdf.bodies import write_pose
from linkwright.stages.export.sdf.lowering import SdfJoint
from linkwright.stages.formats.numbers import LENGTH, TURN, number, spaced
from linkwright.stages.formats.xml import Element, element


def write_joint(model: Element, joint: SdfJoint) -> Element:
    """Writes a joint with its pose and, for a turn or slide, its axis, and returns its element."""
    node = element(model, "joint", name=joint.name, type=joint.type)
    write_pose(node, joint.link_from_joint, joint.pose_link)
    element(node, "parent").text = joint.parent
    element(node, "child").text = joint.child
    if joint.axis is None:
        return node
    axis = element(node, "axis")
    element(axis, "xyz").text = spaced(joint.axis)
    rounding_step = LENGTH if joint.type == "prismatic" else TURN
    limits, dynamics = joint.limits, joint.dynamics
    limit = element(axis, "limit")
    for key, end in (("lower", limits.lower), ("upper", limits.upper)):
        if end is not None:
            element(limit, key).text = number(end, least=rounding_step)
    for key, bound in (("effort", dynamics.effort), ("velocity", dynamics.velocity)):
        if bound is not None:
            element(limit, key).text = number(bound)
    if dynamics.damping is not None or dynamics.friction is not None:
        inner = element(axis, "dynamics")
        for key, value in (("damping", dynamics.damping), ("friction", dynamics.friction)):
            element(inner, key).text = number(value or 0.0)
    if joint.follows is not None:
        mimic = element(axis, "mimic", joint=joint.follows.joint, axis="axis")
        element(mimic, "multiplier").text = number(joint.follows.multiplier)
        element(mimic, "offset").text = number(joint.follows.offset, least=rounding_step)
        element(mimic, "reference").text = "0"
    return node
