"""Where the links of an SDF are when its joints move."""

from collections.abc import Mapping

from linkwright.stages.formats.sdf.model import ReadJoint, SdfModel
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array


def moved_links(model: SdfModel, motions: Mapping[str, Array]) -> dict[str, Array]:
    """model_from_link (4, 4) of every link. `motions`: of joints, how each moves its frame (4, 4); the others
    stay at zero. Of the joints that have a link for their child the first carries it; one without a joint
    stands where the file has it, as do those of a circle of joints."""
    poses = {}
    carriers: dict[str, ReadJoint] = {}
    for joint in model.joints.values():
        carriers.setdefault(joint.child, joint)
    for name, link in model.links.items():
        if name not in carriers or carriers[name].parent not in model.links:
            poses[name] = link.model_from_link
    waiting = [name for name in model.links if name not in poses]
    while ready := [name for name in waiting if carriers[name].parent in poses]:
        for name in ready:
            joint = carriers[name]
            poses[name] = child_pose(model, joint, poses[joint.parent], motions.get(joint.name))
        waiting = [name for name in waiting if name not in poses]
    return poses | {name: model.links[name].model_from_link for name in waiting}


def child_pose(model: SdfModel, joint: ReadJoint, model_from_parent: Array, moved: Array | None) -> Array:
    """model_from_child (4, 4) of a joint whose parent, a link, is there."""
    parent, child = model.links[joint.parent], model.links[joint.child]
    frame = model_from_parent @ inverse(parent.model_from_link) @ joint.model_from_joint
    if moved is not None:
        frame = frame @ moved
    return frame @ inverse(joint.model_from_joint) @ child.model_from_link
