"""Combines a body's joints to one chain of dofs, and finds its joint type.

MuJoCo's joint i moves the body's frame by Pᵢ Mᵢ(q − q₀) Pᵢ⁻¹, where Pᵢ is the shift to its anchor. The frame
of a link is that of its last joint: it has the body's axes, at the anchor of that joint if it turns. So with
the body at B in its parent

    B Π Pᵢ Mᵢ(q − q₀) Pᵢ⁻¹ Pₙ = B P₁ M₁(−q₀) · M₁(q) · P₁⁻¹ P₂ M₂(−q₀) · M₂(q) ...

and each dof's origin is the transform before its motion.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.formats.mjcf.model import MjcfBody, MjcfJoint
from linkwright.stages.graph.dofs import FREEDOMS, Freedom
from linkwright.stages.robot.model.poses import at_rest, from_parts, inverse, motion
from linkwright.stages.robot.model.robot import Array, Dof, DofKind, JointType, Value, frozen

DOF_KINDS: Mapping[str, DofKind] = {"hinge": "turn", "slide": "slide", "ball": "ball", "free": "free"}

SINGLE_JOINT_TYPES: Mapping[str, JointType] = {
    "hinge": "revolute",
    "slide": "prismatic",
    "ball": "ball",
    "free": "free",
}
"""Type of a body's only joint → type of joint."""

FRAME_TOLERANCE = 1e-12
"""Largest difference of an origin from the identity that counts as rounding."""

AXIS_TOLERANCE = 1e-9
"""Largest difference of the dot products of axes from those of a mate."""


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """The dofs of a body, from its parent's frame to its link's."""

    parent_from_start: Array
    """Pose (4, 4) in the parent body of the frame in which the chain of dofs starts."""
    dofs: tuple[Dof, ...]
    body_from_link: Array
    """Pose of the link's frame in the body (4, 4)."""


@dataclass(frozen=True, slots=True)
class BodyJoint:
    """A body's joints as a single joint."""

    name: str
    """Common stem of the joints' names; "" without one."""
    type: JointType
    backwards: bool
    """Whether the dofs are in the order of a mate whose second entity is on the child."""


def chain_of(body: MjcfBody, names: Sequence[str]) -> Chain:
    """Returns the dofs of a body, saved at MuJoCo's reference values `ref`. `names`: the names of the
    dofs."""
    dofs: list[Dof] = []
    previous_frame = np.eye(4)
    anchor_frames = _anchor_frames(body.joints)
    for joint, name, anchor_frame in zip(body.joints, names, anchor_frames, strict=True):
        kind = DOF_KINDS[joint.type]
        is_scalar = kind in ("turn", "slide")
        rest_value: Value = -joint.ref if is_scalar else at_rest(kind)
        origin = inverse(previous_frame) @ anchor_frame @ motion(kind, joint.axis, rest_value)
        saved: Value = joint.ref if is_scalar else rest_value
        axis = frozen(joint.axis + 0.0)
        properties = joint.limits, joint.dynamics
        dofs.append(Dof(name, kind, axis, origin, *properties, saved, spring=joint.spring))
        previous_frame = anchor_frame
    start = body.parent_from_body @ _gather_origins(dofs)
    return Chain(frozen(start), tuple(dofs), frozen(previous_frame))


def _anchor_frames(joints: Sequence[MjcfJoint]) -> list[Array]:
    """Returns the point of action (4, 4) of each joint in the body; a slide gets that of the next joint that
    turns."""
    places: list[Array] = []
    place = np.eye(4)
    for joint in reversed(joints):
        place = place if joint.type == "slide" else from_parts(np.eye(3), joint.anchor)
        places.append(place)
    return places[::-1]


def _gather_origins(dofs: list[Dof]) -> Array:
    """Returns the transform (4, 4) before the first dof, after each origin behind a slide is moved in front
    of it: M(a) O = O M(Oᵀ a). The dofs are changed in place."""
    origins = [dof.origin for dof in dofs]
    for index in range(len(dofs) - 1, 0, -1):
        if dofs[index - 1].kind == "slide":
            origin, origins[index] = origins[index], np.eye(4)
            axis = frozen(origin[:3, :3].T @ dofs[index - 1].axis + 0.0)
            dofs[index - 1] = replace(dofs[index - 1], axis=axis)
            origins[index - 1] = origins[index - 1] @ origin
    start = origins[0] if dofs else np.eye(4)
    for index, dof in enumerate(dofs):
        is_identity = not index or np.abs(origins[index] - np.eye(4)).max() < FRAME_TOLERANCE
        dofs[index] = replace(dof, origin=frozen(np.eye(4) if is_identity else origins[index]))
    return start


def body_joint(dofs: Sequence[Dof]) -> BodyJoint:
    """Returns the joint type of a body's dofs, by their kinds, axes and names; else `compound`."""
    names = [dof.name for dof in dofs]
    for kind, freedoms in FREEDOMS.items():
        if len(freedoms) < 2 or len(freedoms) != len(dofs):
            continue
        for backwards in (False, True):
            freedoms_in_order = freedoms[::-1] if backwards else freedoms
            stem = names[0].removesuffix(freedoms_in_order[0].suffix)
            if (
                stem
                and names == [stem + freedom.suffix for freedom in freedoms_in_order]
                and _fits(dofs, freedoms_in_order)
            ):
                return BodyJoint(stem, kind, backwards)
    return BodyJoint("", "compound", False)


def _fits(dofs: Sequence[Dof], freedoms: Sequence[Freedom]) -> bool:
    """Tells whether the dofs move as these freedoms do, if a rotation may be applied to all axes. A slide
    along the axis of a turn may have the opposite direction, as in a mirrored mate."""
    if any(dof.kind != freedom.kind for dof, freedom in zip(dofs, freedoms, strict=True)):
        return False
    if any(np.abs(dof.origin - np.eye(4)).max() > AXIS_TOLERANCE for dof in dofs):
        return False
    axes = np.array([dof.axis for dof in dofs])
    expected = np.array([freedom.axis for freedom in freedoms], dtype=float)
    return bool(np.abs(np.abs(axes @ axes.T) - np.abs(expected @ expected.T)).max() < AXIS_TOLERANCE)
