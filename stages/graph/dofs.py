"""What each type of mate lets move: its dofs, their values in a pose, and the chain run backwards.

With W₀, W₁ the world frames of a mate's first and second entity, M = W₁⁻¹ W₀ is the pose of the first
relative to the second: slides along the second's axes, then a turn about their common z. Limits have
the names that the API gives them.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.robot.model import Array, Dof, DofKind, Dynamics, JointType, Limits, Value, frozen
from stages.robot.poses import at_rest, inverse, quat_from_rotation


@dataclass(frozen=True, slots=True)
class Freedom:
    """One dof of a type of mate: what its name ends in, kind, axis, and its limits in the API's names."""

    suffix: str
    kind: DofKind
    axis: tuple[float, float, float]
    limits: tuple[str, str]


X = Freedom("_x", "slide", (1, 0, 0), ("limitXMin", "limitXMax"))
Y = Freedom("_y", "slide", (0, 1, 0), ("limitYMin", "limitYMax"))
Z = Freedom("_z", "slide", (0, 0, 1), ("limitZMin", "limitZMax"))
SLIDE = replace(Z, suffix="_slide")
TURN = Freedom("_turn", "turn", (0, 0, 1), ("limitAxialZMin", "limitAxialZMax"))
BALL = Freedom("", "ball", (0, 0, 0), ("", "limitEulerConeAngleMax"))

TYPES: Mapping[str, tuple[JointType, tuple[Freedom, ...]]] = {
    "FASTENED": ("fixed", ()),
    "FIXED": ("fixed", ()),
    "REVOLUTE": ("revolute", (TURN,)),
    "SLIDER": ("prismatic", (SLIDE,)),
    "CYLINDRICAL": ("cylindrical", (SLIDE, TURN)),
    "PIN_SLOT": ("pin_slot", (replace(X, suffix="_slide"), TURN)),
    "PLANAR": ("planar", (X, Y, TURN)),
    "PARALLEL": ("parallel", (X, Y, Z, TURN)),
    "BALL": ("ball", (BALL,)),
}
"""Mate type → joint type and freedoms, from the second entity to the first. FIXED is drawn by nobody: it
is a FASTENED mate that keeps its two links apart."""

MIRRORED = np.diag([1.0, 1.0, -1.0, 1.0])


def dof_names(name: str, mate_type: str) -> tuple[str, ...]:
    """The names of the dofs of a mate called `name`: its own where it has but one."""
    freedoms = TYPES[mate_type][1]
    return (name,) if len(freedoms) == 1 else tuple(name + freedom.suffix for freedom in freedoms)


def right_handed(first: Array, second: Array) -> tuple[Array, Array, bool]:
    """The two frames (4, 4) of a mate as right-handed ones, and whether both were mirrored.

    Under a reflection S a slide's axis becomes S·z and a turn's −S·z: with both frames' z turned
    round the turns keep their axis, and a slide along z has the opposite one. Of a single left-handed
    frame y is turned round, as x and z are what mates align.
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
) -> tuple[Dof, ...]:
    """The dofs of a mate whose first entity is at `relative` (4, 4) in its second, both right-handed."""
    made = []
    for dof_name, freedom in zip(dof_names(name, mate_type), TYPES[mate_type][1], strict=True):
        axis = np.array(freedom.axis, dtype=float)
        if mirrored and freedom.kind == "slide":
            axis = MIRRORED[:3, :3] @ axis
        low, high = freedom.limits
        made.append(
            Dof(
                name=dof_name,
                kind=freedom.kind,
                axis=frozen(axis + 0.0),
                origin=frozen(np.eye(4)),
                limits=Limits(limits.get(low), limits.get(high)),
                dynamics=Dynamics(),
                saved=value_in(relative, freedom.kind, axis),
            )
        )
    return tuple(made)


def value_in(relative: Array, kind: DofKind, axis: Array) -> Value:
    """What a dof of this kind and axis explains of a pose (4, 4): rad, m, or a quaternion."""
    if kind == "slide":
        return float(relative[:3, 3] @ axis)
    if kind == "turn":
        return math.atan2(relative[1, 0], relative[0, 0]) * float(np.sign(axis[2]))
    quat = tuple(float(number) for number in quat_from_rotation(relative[:3, :3]))
    return quat if kind == "ball" else (*(float(number) for number in relative[:3, 3]), *quat)


def residual(relative: Array, explained: Array) -> float:
    """How far two poses (4, 4) are apart: the larger of the offset [m] and the turn [rad, small]."""
    off = inverse(explained) @ relative
    return max(
        float(np.linalg.norm(off[:3, 3])),
        float(np.linalg.norm(off[:3, :3] - np.eye(3))) / math.sqrt(2),
    )


def backwards(dofs: Sequence[Dof]) -> tuple[Dof, ...]:
    """The chain from the first entity to the second: dofs in reverse, each undoing its motion.

    (O₁M₁ O₂M₂ … OₙMₙ)⁻¹ = Mₙ⁻¹ Oₙ⁻¹ … M₁⁻¹ O₁⁻¹, and O₁ is the identity.
    """
    made = []
    before = np.eye(4)
    for dof in reversed(dofs):
        saved = dof.saved
        if dof.kind == "ball":
            saved = conjugate(saved)
        made.append(replace(dof, axis=frozen(-dof.axis + 0.0), origin=frozen(before), saved=saved))
        before = inverse(dof.origin) + 0.0
    return tuple(made)


def conjugate(quat: Value) -> Value:
    """The opposite rotation of a quaternion (w, x, y, z)."""
    w, x, y, z = quat if isinstance(quat, tuple) else at_rest("ball")  # type: ignore[misc]
    return (w, -x + 0.0, -y + 0.0, -z + 0.0)
