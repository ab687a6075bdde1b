"""Computes rigid transforms and rotations: (4, 4) and (3, 3) arrays, quaternions as (w, x, y, z)."""

import math

import numpy as np

from linkwright.stages.robot.model.robot import Array, DofKind, Value, frozen

UNMOVED = frozen(np.eye(4))
"""The identity (4, 4): the pose of a frame in itself. It is read-only."""


def inverse(a_from_b: Array) -> Array:
    """Returns the inverse b_from_a of a rigid (or reflecting) transform (4, 4)."""
    rotation = a_from_b[:3, :3]
    return from_parts(rotation.T, -rotation.T @ a_from_b[:3, 3])


def from_parts(rotation: Array, position: Array) -> Array:
    """Returns the (4, 4) transform with this rotation (3, 3) and position (3,)."""
    transform = UNMOVED.copy()
    transform[:3, :3] = rotation
    transform[:3, 3] = position
    return transform


def at_rest(kind: DofKind) -> Value:
    """Returns the value at which a dof of this kind does not move its frame."""
    if kind == "ball":
        return (1.0, 0.0, 0.0, 0.0)
    if kind == "free":
        return (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    return 0.0


def motion(kind: DofKind, axis: Array, value: Value) -> Array:
    """Returns the transform (4, 4) by which a dof moves its frame at `value` (see `dofs.Value`). `axis`: the
    unit vector (3,) of a turn or a slide."""
    transform = UNMOVED.copy()
    if isinstance(value, tuple):
        transform[:3, :3] = rotation_from_quat(np.array(value[-4:]))
        # The value of a ball has no position.
        transform[:3, 3] = value[:-4] or 0.0
    elif kind == "slide":
        transform[:3, 3] = np.asarray(axis) * value
    elif value:
        transform[:3, :3] = turn(axis, value)
    return transform


def turn(axis: Array, angle: float) -> Array:
    """Returns Rodrigues' rotation (3, 3) by `angle` [rad] about the unit vector `axis` (3,)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # 1 − cos from the half angle keeps full precision near zero.
    rotation: Array = np.eye(3) + math.sin(angle) * cross + 2.0 * math.sin(angle / 2.0) ** 2 * (cross @ cross)
    return rotation


def rotation_from_rpy(rpy: tuple[float, float, float]) -> Array:
    """Returns the rotation (3, 3) of URDF's roll, pitch and yaw [rad]: Rz(yaw) Ry(pitch) Rx(roll)."""
    roll, pitch, yaw = rpy
    x, y, z = np.eye(3)
    return turn(z, yaw) @ turn(y, pitch) @ turn(x, roll)


def rpy_from_rotation(rotation: Array) -> tuple[float, float, float]:
    """Returns URDF's roll, pitch and yaw [rad] of a rotation (3, 3).

    The result is exact near pitch = ±90° too: the roll is computed from the rotation without the yaw, so that
    the product of the three is the rotation again, however it is split between roll and yaw.
    """
    r = rotation
    cos_pitch = math.hypot(r[0, 0], r[1, 0])
    pitch = math.atan2(-r[2, 0], cos_pitch)
    # At ±90° both arguments are rounding errors and any yaw is correct: 0 is the plainest.
    yaw = math.atan2(r[1, 0], r[0, 0]) if cos_pitch > 1e-15 else 0.0
    # The middle row of Rz(-yaw) R = Ry(pitch) Rx(roll) is (0, cos roll, -sin roll).
    sin_yaw, cos_yaw = math.sin(yaw), math.cos(yaw)
    roll = math.atan2(
        sin_yaw * r[0, 2] - cos_yaw * r[1, 2],
        cos_yaw * r[1, 1] - sin_yaw * r[0, 1],
    )
    return roll, pitch, yaw


def quat_from_rotation(rotation: Array) -> Array:
    """Returns the unit quaternion (4,) as (w, x, y, z), w ≥ 0, of a rotation (3, 3).

    This is Shepperd's method: the largest of the four components is the divisor, so that no digits are lost.
    """
    r: list[list[float]] = np.asarray(rotation, dtype=float).tolist()
    trace = r[0][0] + r[1][1] + r[2][2]
    squares = [trace, r[0][0], r[1][1], r[2][2]]
    largest = squares.index(max(squares))
    if largest == 0:
        q = [1 + trace, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        q = [r[k][j] - r[j][k], 0.0, 0.0, 0.0]
        q[1 + i] = 1 + r[i][i] - r[j][j] - r[k][k]
        q[1 + j] = r[j][i] + r[i][j]
        q[1 + k] = r[k][i] + r[i][k]
    length = math.copysign(math.hypot(*q), q[0])
    return np.array([part / length for part in q])


def rotation_from_quat(quat: Array) -> Array:
    """Returns the rotation (3, 3) of a quaternion (w, x, y, z), normalised here."""
    w, x, y, z = np.asarray(quat, dtype=float) / np.linalg.norm(quat)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def turns_from_rotation(rotation: Array) -> tuple[float, float, float]:
    """Returns (x, y, z) [rad] with Rx(x) Ry(y) Rz(z) = `rotation` (3, 3); z is 0 if y is ±90°."""
    r = rotation
    y = math.atan2(r[0, 2], math.hypot(r[0, 0], r[0, 1]))
    z = math.atan2(-r[0, 1], r[0, 0]) if math.hypot(r[0, 0], r[0, 1]) > 1e-12 else 0.0
    # The second column of R Rz(-z) = Rx(x) Ry(y) is (0, cos x, sin x).
    column = math.cos(z) * r[:, 1] + math.sin(z) * r[:, 0]
    return math.atan2(column[2], column[1]), y, z
