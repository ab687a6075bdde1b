"""Converts mates to joints: the joint of each type of mate, its dofs, and the names of their limits.

With W₀, W₁ the world frames of a mate's first and second entity, M = W₁⁻¹ W₀ is the pose of the first
relative to the second: slides along the second's axes, then a turn about their common z.
"""

from collections.abc import Mapping

import numpy as np

from linkwright.stages.graph.dofs import FREEDOMS, Freedom, value_in
from linkwright.stages.robot.model.dofs import AS_TYPED, LimitOrigin
from linkwright.stages.robot.model.robot import Array, Dof, Dynamics, JointType, Limits, frozen

JOINT_TYPES: Mapping[str, JointType] = {
    "FASTENED": "fixed",
    "FIXED": "fixed",
    "REVOLUTE": "revolute",
    "SLIDER": "prismatic",
    "CYLINDRICAL": "cylindrical",
    "PIN_SLOT": "pin_slot",
    "PLANAR": "planar",
    "PARALLEL": "parallel",
    "BALL": "ball",
}
"""Mate type → joint type. FIXED is not a type of Onshape: it is a FASTENED mate between two links that are
not merged."""

MIRRORED = np.diag([1.0, 1.0, -1.0, 1.0])
"""Reverses the z axis of a frame."""


def freedoms_of(mate_type: str) -> tuple[Freedom, ...]:
    """Returns the dofs of a type of mate, from the second entity to the first."""
    return FREEDOMS[JOINT_TYPES[mate_type]]


def limit_names(freedom: Freedom) -> tuple[str, str]:
    """Returns the API's names of a dof's lower and upper limits; "" for a limit that mates do not have."""
    if freedom.kind == "ball":
        return "", "limitEulerConeAngleMax"
    axis = "XYZ"[freedom.axis.index(1)]
    side = f"Axial{axis}" if freedom.kind == "turn" else axis
    return f"limit{side}Min", f"limit{side}Max"


def dof_names(name: str, mate_type: str) -> tuple[str, ...]:
    """Returns the names of the dofs of a mate called `name`; a single dof has the name of the mate."""
    freedoms = freedoms_of(mate_type)
    return (name,) if len(freedoms) == 1 else tuple(name + freedom.suffix for freedom in freedoms)


def right_handed(first: Array, second: Array) -> tuple[Array, Array, bool]:
    """Returns the two frames (4, 4) of a mate, made right-handed, and whether both were mirrored.

    A reflection S maps the axis z of a slide to S·z, but that of a turn to −S·z. So if both frames are
    left-handed, their z are reversed: turns keep their axis, and `dofs_of` reverses the axis of a slide along
    z. If only one frame is left-handed, its y is reversed, since mates align x and z.
    """
    hands = [np.linalg.det(frame[:3, :3]) > 0 for frame in (first, second)]
    if not any(hands):
        return first @ MIRRORED, second @ MIRRORED, True
    flip = np.diag([1.0, -1.0, 1.0, 1.0])
    return first if hands[0] else first @ flip, second if hands[1] else second @ flip, False


def dofs_of(
    name: str,
    mate_type: str,
    limits: Mapping[str, float],
    relative: Array,
    mirrored: bool = False,
    origin: LimitOrigin = AS_TYPED,
) -> tuple[Dof, ...]:
    """Returns the dofs of a mate whose first entity is at `relative` (4, 4) in its second, both right-handed.
    `mirrored`: whether `right_handed` mirrored both frames."""
    dofs = []
    for dof_name, freedom in zip(dof_names(name, mate_type), freedoms_of(mate_type), strict=True):
        axis = np.array(freedom.axis, dtype=float)
        if mirrored and freedom.kind == "slide":
            axis = MIRRORED[:3, :3] @ axis
        low, high = limit_names(freedom)
        # Adding 0.0 turns a -0.0 in the axis into 0.0.
        dofs.append(
            Dof(
                name=dof_name,
                kind=freedom.kind,
                axis=frozen(axis + 0.0),
                origin=frozen(np.eye(4)),
                limits=Limits(limits.get(low), limits.get(high), origin=origin),
                dynamics=Dynamics(),
                saved=value_in(relative, freedom.kind, axis),
            )
        )
    return tuple(dofs)
