"""Computes the poses of an SDF's links when its joints move."""

from collections.abc import Mapping

from linkwright.stages.formats.sdf.model import ReadJoint, SdfModel
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array


def moved_links(model: SdfModel, motions: Mapping[str, Array]) -> dict[str, Array]:
    """Returns model_from_link (4, 4) of every link.

    `motions`: by joint, the motion of its frame (4, 4); other joints stay at zero. The first joint whose
    child is a link carries it. A link without a joint keeps its pose in the file, and so do the links of a
    circle of joints.
    """
    poses = {}
    carriers: dict[str, ReadJoint] = {}
    for joint in model.joints.values():
        carriers.setdefault(joint.child, joint)
    for name, link in model.links.items():
        if name not in carriers or carriers[name].parent not in model.links:
            poses[name] = link.model_from_link
    unplaced = [name for name in model.links if name not in poses]
    while ready := [name for name in unplaced if carriers[name].parent in poses]:
        for name in ready:
            joint = carriers[name]
            poses[name] = child_pose(model, joint, poses[joint.parent], motions.get(joint.name))
        unplaced = [name for name in unplaced if name not in poses]
    return poses | {name: model.links[name].model_from_link for name in unplaced}


def child_pose(model: SdfModel, joint: ReadJoint, model_from_parent: Array, motion: Array | None) -> Array:
    """Returns model_from_child (4, 4) of a joint whose parent is a link."""
    parent, child = model.links[joint.parent], model.links[joint.child]
    frame = model_from_parent @ inverse(parent.model_from_link) @ joint.model_from_joint
    if motion is not None:
        frame = frame @ motion
    return frame @ inverse(joint.model_from_joint) @ child.model_from_link
