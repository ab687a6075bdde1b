"""Computes the robot's kinematics at many configurations at once. The first axis of every array is the
configuration."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.poses import at_rest
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Joint, Robot

Values = Mapping[str, Array]
"""Dof → values: (n,) for a turn or slide, (n, 4) for a ball, (n, 7) for a free joint."""

Frames = Mapping[str, tuple[Array, Array]]
"""Dof → its frame before its motion and after it, as root_from_frame (n, 4, 4)."""


class ChainPose(NamedTuple):
    """The poses of a chain of dofs, in the frame in which the chain's start is given."""

    end: Array
    """Pose (n, 4, 4) of the end of the chain."""

    frames: Frames
    """The frames of the chain's dofs."""


def repeated(q: Configuration, count: int) -> dict[str, Array]:
    """Returns the same configuration `count` times."""
    # A scalar is repeated to (count,), and a tuple to (count, its length).
    return {
        name: np.tile(np.asarray(value, dtype=float), (count, 1)[: np.ndim(value) + 1])
        for name, value in q.items()
    }


def select(values: Values, rows: npt.NDArray[np.intp] | npt.NDArray[np.bool_]) -> dict[str, Array]:
    """Returns some of the configurations, by index or by a mask."""
    return {name: value[rows] for name, value in values.items()}


def count_of(values: Values) -> int:
    """Returns the number of configurations; 1 for a robot without dofs."""
    return next((len(value) for value in values.values()), 1)


def many_link_poses(robot: Robot, values: Values) -> dict[str, Array]:
    """Returns root_from_link (n, 4, 4) of every link."""
    poses, _ = poses_and_frames(robot.root.name, robot.joints, values)
    return poses


def poses_and_frames(
    root: str, joints: Iterable[Joint], values: Values
) -> tuple[dict[str, Array], dict[str, tuple[Array, Array]]]:
    """Returns root_from_link (n, 4, 4) of `root` and of the children of these joints, and the frames of their
    dofs. `joints`: parents first, all at or below `root`."""
    poses = {root: np.tile(np.eye(4), (count_of(values), 1, 1))}
    frames: dict[str, tuple[Array, Array]] = {}
    for joint in joints:
        chain = chain_pose(joint.dofs, poses[joint.parent] @ joint.parent_from_joint, values)
        poses[joint.child] = chain.end
        frames |= chain.frames
    return poses, frames


def chain_pose(dofs: Iterable[Dof], start: Array, values: Values) -> ChainPose:
    """Returns the poses of a chain of dofs that begins at `start` (n, 4, 4)."""
    pose = start
    frames = {}
    for dof in dofs:
        frame = pose @ dof.origin
        pose = frame @ dof_transforms(dof, values)
        frames[dof.name] = frame, pose
    return ChainPose(pose, frames)


def dof_transforms(dof: Dof, values: Values) -> Array:
    """Returns the transforms (n, 4, 4) by which a dof moves its frame; the identity for a dof without
    values."""
    if dof.name not in values:
        values = repeated({dof.name: at_rest(dof.kind)}, count_of(values))
    value = values[dof.name]
    transforms = np.tile(np.eye(4), (len(value), 1, 1))
    if dof.kind == "slide":
        transforms[:, :3, 3] = value[:, None] * dof.axis
    elif dof.kind == "turn":
        transforms[:, :3, :3] = rotations_from_vectors(value[:, None] * dof.axis)
    else:
        transforms[:, :3, :3] = rotations_from_quats(value[:, -4:])
        if dof.kind == "free":
            transforms[:, :3, 3] = value[:, :3]
    return transforms


def rotations_from_vectors(vectors: Array) -> Array:
    """Returns the rotations (n, 3, 3) of rotation vectors (n, 3) [rad]."""
    return rotations_from_quats(quats_from_vectors(vectors))


def quats_from_vectors(vectors: Array) -> Array:
    """Returns the quaternions (w, x, y, z) (n, 4) of rotation vectors (n, 3) [rad]."""
    half = np.linalg.norm(vectors, axis=1)[:, None] / 2
    # np.sinc(x / π) is sin(x) / x, also at 0.
    quats: Array = np.concatenate([np.cos(half), np.sinc(half / np.pi) * vectors / 2], axis=1)
    return quats


def rotations_from_quats(quats: Array) -> Array:
    """Returns the rotations (n, 3, 3) of quaternions (w, x, y, z) (n, 4), which need not have unit length."""
    w, x, y, z = (quats / np.linalg.norm(quats, axis=1)[:, None]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def quat_products(first: Array, second: Array) -> Array:
    """Returns the products (n, 4) of quaternions (w, x, y, z) (n, 4)."""
    a, b = first[:, 0], second[:, 0]
    u, v = first[:, 1:], second[:, 1:]
    scalar = a * b - np.einsum("ij,ij->i", u, v)
    return np.column_stack([scalar, a[:, None] * v + b[:, None] * u + cross(u, v)])


_NEXT, _AFTER_NEXT = [1, 2, 0], [2, 0, 1]
"""For each of x, y, z: the index of the next coordinate, and of the coordinate after that."""


def cross(first: Array, second: Array) -> Array:
    """Returns the cross products (n, 3, ...) of vectors (n, 3, ...) along the second axis."""
    # np.cross, which accepts any axes, takes ten times as long for a few hundred vectors.
    product: Array = first[:, _NEXT] * second[:, _AFTER_NEXT] - first[:, _AFTER_NEXT] * second[:, _NEXT]
    return product


_MIN_SINE = 1e-9
"""Sine of an angle at or below which a rotation counts as the identity or as half a turn: rounding hides its
axis."""


def vectors_from_rotations(rotations: Array) -> Array:
    """Returns the rotation vectors (n, 3) [rad], up to π long, of rotations (n, 3, 3). For half a turn the
    axis is x, whatever the axis of the rotation is."""
    r = rotations
    # The axis, times twice the sine of the angle.
    doubled = np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1)
    sines = np.linalg.norm(doubled, axis=1) / 2
    angles = np.arctan2(sines, (np.trace(r, axis1=1, axis2=2) - 1) / 2)
    factors = np.divide(angles, 2 * sines, out=np.full_like(angles, 0.5), where=sines > _MIN_SINE)
    vectors: Array = doubled * factors[:, None]
    # At half a turn `doubled` is zero and has no direction. Callers need the angle alone.
    is_half_turn = (sines <= _MIN_SINE) & (angles > np.pi / 2)
    vectors[is_half_turn] = [np.pi, 0, 0]
    return vectors
