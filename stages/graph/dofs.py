"""Lists the dofs of each type of joint, computes their values in a pose, and reverses chains of dofs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.robot.model.poses import at_rest, inverse, quat_from_rotation
from linkwright.stages.robot.model.robot import Array, Dof, DofKind, JointType, Value, frozen


@dataclass(frozen=True, slots=True)
class Freedom:
    """A dof of a type of joint: the suffix of its name, its kind and its axis."""

    suffix: str
    kind: DofKind
    axis: tuple[float, float, float]


X = Freedom("_x", "slide", (1, 0, 0))
Y = Freedom("_y", "slide", (0, 1, 0))
Z = Freedom("_z", "slide", (0, 0, 1))
SLIDE = replace(Z, suffix="_slide")
TURN = Freedom("_turn", "turn", (0, 0, 1))
BALL = Freedom("", "ball", (0, 0, 0))

FREEDOMS: Mapping[JointType, tuple[Freedom, ...]] = {
    "fixed": (),
    "revolute": (TURN,),
    "prismatic": (SLIDE,),
    "cylindrical": (SLIDE, TURN),
    "pin_slot": (replace(X, suffix="_slide"), TURN),
    "planar": (X, Y, TURN),
    "parallel": (X, Y, Z, TURN),
    "ball": (BALL,),
}
"""Joint type → its dofs in order, from the second entity of a mate to the first."""


def value_in(relative: Array, kind: DofKind, axis: Array) -> Value:
    """Returns the value of a dof of this kind and axis at a relative pose (4, 4): a distance [m] along the
    axis, an angle [rad] about z (with the sign of the axis), a quaternion, or a position with a
    quaternion."""
    if kind == "slide":
        return float(relative[:3, 3] @ axis)
    if kind == "turn":
        return math.atan2(relative[1, 0], relative[0, 0]) * float(np.sign(axis[2]))
    quat = tuple(float(number) for number in quat_from_rotation(relative[:3, :3]))
    return quat if kind == "ball" else (*(float(number) for number in relative[:3, 3]), *quat)


def residual(relative: Array, explained: Array) -> float:
    """Returns the difference of two poses (4, 4): the larger of the offset [m] and the angle [rad], if
    small."""
    difference = inverse(explained) @ relative
    # For a turn by a small angle, the norm of R − 1 is √2 times the angle.
    return max(
        float(np.linalg.norm(difference[:3, 3])),
        float(np.linalg.norm(difference[:3, :3] - np.eye(3))) / math.sqrt(2),
    )


def reversed_dofs(dofs: Sequence[Dof]) -> tuple[Dof, ...]:
    """Returns the chain from the first entity to the second: the dofs in reverse order, each of which undoes
    its motion.

    (O₁M₁ O₂M₂ … OₙMₙ)⁻¹ = Mₙ⁻¹ Oₙ⁻¹ … M₁⁻¹ O₁⁻¹, and O₁ is the identity.
    """
    chain = []
    origin = np.eye(4)
    for dof in reversed(dofs):
        saved = dof.saved
        if dof.kind == "ball":
            saved = conjugate(saved)
        chain.append(replace(dof, axis=frozen(-dof.axis + 0.0), origin=frozen(origin), saved=saved))
        origin = inverse(dof.origin) + 0.0
    return tuple(chain)


def conjugate(quat: Value) -> Value:
    """Returns the opposite rotation of a quaternion (w, x, y, z)."""
    w, x, y, z = quat if isinstance(quat, tuple) else at_rest("ball")  # type: ignore[misc]
    return (w, -x + 0.0, -y + 0.0, -z + 0.0)
