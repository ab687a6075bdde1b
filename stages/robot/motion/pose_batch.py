"""Computes the robot's kinematics at many configurations at once: the first axis of every array counts
them."""

from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.poses import at_rest
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Joint, Robot

Values = Mapping[str, Array]
"""Dof → values: (n,) for a turn or slide, (n, 4) for a ball, (n, 7) for a free joint."""


def repeated(q: Configuration, count: int) -> dict[str, Array]:
    """Returns the same configuration `count` times."""
    return {
        name: np.tile(np.asarray(value, dtype=float), (count, 1)[: np.ndim(value) + 1])
        for name, value in q.items()
    }


def chosen(values: Values, rows: npt.NDArray[np.intp] | npt.NDArray[np.bool_]) -> dict[str, Array]:
    """Returns some of the configurations, by index or by a mask."""
    return {name: value[rows] for name, value in values.items()}


def count_of(values: Values) -> int:
    """Returns the number of configurations; 1 for a robot without dofs."""
    return next((len(value) for value in values.values()), 1)


def many_link_poses(robot: Robot, values: Values) -> dict[str, Array]:
    """Returns root_from_link (n, 4, 4) of every link."""
    return placed(robot.root.name, robot.joints, values)[0]


def placed(
    root: str, joints: Iterable[Joint], values: Values
) -> tuple[dict[str, Array], dict[str, tuple[Array, Array]]]:
    """Returns root_from_link (n, 4, 4) below these joints (parents first), and two frames (n, 4, 4) for each
    of their dofs: the frame in which it moves, and the frame that it moves."""
    poses = {root: np.tile(np.eye(4), (count_of(values), 1, 1))}
    frames: dict[str, tuple[Array, Array]] = {}
    for joint in joints:
        poses[joint.child] = along(joint.dofs, poses[joint.parent] @ joint.parent_from_joint, values, frames)
    return poses, frames


def along(dofs: Iterable[Dof], start: Array, values: Values, frames: dict[str, tuple[Array, Array]]) -> Array:
    """Returns the end (n, 4, 4) of a chain of dofs that begins at `start` (n, 4, 4); `frames` gets the frames
    of each."""
    pose = start
    for dof in dofs:
        frame = pose @ dof.origin
        pose = frame @ motions(dof, values)
        frames[dof.name] = frame, pose
    return pose


def motions(dof: Dof, values: Values) -> Array:
    """Returns the transforms (n, 4, 4) of a dof; a dof without values does not move."""
    if dof.name not in values:
        values = repeated({dof.name: at_rest(dof.kind)}, count_of(values))
    value = values[dof.name]
    out = np.tile(np.eye(4), (len(value), 1, 1))
    if dof.kind == "slide":
        out[:, :3, 3] = value[:, None] * dof.axis
    elif dof.kind == "turn":
        out[:, :3, :3] = rotations(value[:, None] * dof.axis)
    else:
        out[:, :3, :3] = rotations_of_quats(value[:, -4:])
        if dof.kind == "free":
            out[:, :3, 3] = value[:, :3]
    return out


def rotations(vectors: Array) -> Array:
    """Returns Rodrigues' rotations (n, 3, 3) about the vectors (n, 3), by their lengths [rad]."""
    return rotations_of_quats(quats_of(vectors))


def quats_of(vectors: Array) -> Array:
    """Returns the quaternions (n, 4), as (w, x, y, z), of turns about the vectors (n, 3), by their lengths
    [rad]."""
    half = np.linalg.norm(vectors, axis=1)[:, None] / 2
    # sin(x)/x, which np.sinc computes for π x, is exact at 0.
    quats: Array = np.concatenate([np.cos(half), np.sinc(half / np.pi) * vectors / 2], axis=1)
    return quats


def rotations_of_quats(quats: Array) -> Array:
    """Returns the rotations (n, 3, 3) of quaternions (n, 4), normalised here."""
    w, x, y, z = (quats / np.linalg.norm(quats, axis=1)[:, None]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def product_of_quats(first: Array, second: Array) -> Array:
    """Returns the products (n, 4) of quaternions (n, 4), by Hamilton's rule."""
    a, b = first[:, 0], second[:, 0]
    u, v = first[:, 1:], second[:, 1:]
    scalar = a * b - np.einsum("ij,ij->i", u, v)
    return np.column_stack([scalar, a[:, None] * v + b[:, None] * u + cross(u, v)])


def cross(first: Array, second: Array) -> Array:
    """Returns the products (n, 3, ...) of vectors along the second axis."""
    # np.cross, which takes any axes, costs ten times as much for a few hundred vectors.
    product: Array = first[:, _NEXT] * second[:, _LAST] - first[:, _LAST] * second[:, _NEXT]
    return product


_NEXT, _LAST = [1, 2, 0], [2, 0, 1]


def turns_of(rotations: Array) -> Array:
    """Returns the rotation vectors (n, 3), of lengths [rad] up to π, of rotations (n, 3, 3)."""
    r = rotations
    doubled = np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1)
    sines = np.linalg.norm(doubled, axis=1) / 2
    angles = np.arctan2(sines, (np.trace(r, axis1=1, axis2=2) - 1) / 2)
    factors = np.divide(angles, 2 * sines, out=np.full_like(angles, 0.5), where=sines > 1e-9)
    vectors: Array = doubled * factors[:, None]
    # Half a turn has no axis there: any axis will do, as long as the turn is not lost.
    vectors[(sines <= 1e-9) & (angles > 1)] = [np.pi, 0, 0]
    return vectors
