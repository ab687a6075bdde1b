"""Finds the points on which a free robot stands at a pose, and the weight that each of them carries."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy

from linkwright.stages.export.ground.extents import Extents
from linkwright.stages.robot.dynamics.statics import GroundSupport
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.poses import inverse, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.kinematics import link_poses

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.scene_section import GroundSection

MAX_HEIGHT = 2e-3
"""Largest height [m] above the ground of points that touch it."""

DIRECTIONS = 16
"""Number of directions in the plane of the ground. The furthest point of a link in each of them represents
all its points that touch the ground."""

BALANCE_TOLERANCE = 1e-6
"""Tolerance of a balance, as a share of the weight; for moments, of the weight times the size of the
footing."""

_BALANCE_PRIORITY = 1e3
"""Factor of the balance's rows relative to the rows of the sum of squares, which chooses among the ways to
share a weight."""


def ground_supports(
    robot: Robot,
    geometry: Geometry,
    world_from_root: Array,
    ground: "GroundSection",
    q: Configuration,
    up: Array,
) -> tuple[GroundSupport, ...]:
    """Returns the points on which the robot stands at `q`, and the forces of the ground that balance its
    weight. The forces are along `up` (3,) [m/s², in the root link's axes], and have the least sum of squares.
    Returns () if the robot has no weight or does not stand: nothing touches the ground, or the centre of mass
    is not above the points that do. `world_from_root` (4, 4): the pose of the root link."""
    if ground.kind == "none" or not np.any(up):
        return ()
    contacts = list(ground_contacts(robot, geometry, world_from_root, ground, q))
    if not contacts or not any(link.inertial.mass for link in robot.links):
        return ()
    links, points = zip(*contacts, strict=True)
    mass, centre = mass_and_center(robot, q)
    shares = weight_shares(np.array(points), centre, up)
    return tuple(
        GroundSupport(link, point, float(share * mass))
        for link, point, share in zip(links, points, shares, strict=True)
        if share > 0.0
    )


def weight_shares(points: Array, centre: Array, up: Array) -> Array:
    """Returns the share (n,) of a weight at `centre` (3,) that each of the points (n, 3) carries, with forces
    along `up` (3,); all zero if the weight cannot be balanced by pushing alone.

    The shares have the least sum of squares under the balance of forces and moments. Non-negative least
    squares (Lawson and Hanson, "Solving Least Squares Problems", chapter 23), with the balance as rows with
    the factor `_BALANCE_PRIORITY`, choose the points; the exact shares of these points follow by the
    pseudoinverse.
    """
    in_plane = (points - centre) @ _plane_axes(up).T
    rows = np.vstack([np.ones(len(in_plane)), in_plane.T / max(float(np.abs(in_plane).max()), 1e-9)])
    balance = np.array([1.0, 0.0, 0.0])
    approximate, _ = scipy.optimize.nnls(
        np.vstack([_BALANCE_PRIORITY * rows, np.eye(len(in_plane))]),
        np.concatenate([_BALANCE_PRIORITY * balance, np.zeros(len(in_plane))]),
    )
    # What is smaller is rounding, which differs between machines.
    used = approximate > 0.1 * BALANCE_TOLERANCE
    shares = np.zeros(len(in_plane))
    shares[used] = np.linalg.pinv(rows[:, used]) @ balance
    error = np.abs(rows @ shares - balance).max()
    stands = error <= BALANCE_TOLERANCE and shares.min() >= -BALANCE_TOLERANCE
    return np.maximum(shares, 0.0) if stands else np.zeros(len(in_plane))


def mass_and_center(robot: Robot, q: Configuration) -> tuple[float, Array]:
    """Returns the mass [kg] of a robot that has mass, and its centre of mass (3,) [m] at `q` in the root
    link's axes."""
    poses = link_poses(robot, q)
    mass = sum(link.inertial.mass for link in robot.links)
    moment = sum(
        link.inertial.mass * (poses[link.name] @ np.append(link.inertial.com, 1.0))[:3]
        for link in robot.links
    )
    return mass, moment / mass


def ground_contacts(
    robot: Robot, geometry: Geometry, world_from_root: Array, ground: "GroundSection", q: Configuration
) -> Iterator[tuple[str, Array]]:
    """Yields (link, point (3,) [m] in the root link's axes) for the points of colliders that touch the
    ground."""
    normal = rotation_from_rpy(ground.rpy)[:, 2]
    poses = link_poses(robot, q)
    extents = Extents(geometry, {link: world_from_root @ pose for link, pose in poses.items()})
    root_from_world = inverse(world_from_root)
    limit = float(normal @ ground.xyz) + MAX_HEIGHT
    for link in robot.links:
        touching_points = extents.points_below(link.name, "collision", normal, limit)
        for point in _furthest_points(touching_points, normal):
            yield link.name, (root_from_world @ np.append(point, 1.0))[:3]


def _furthest_points(points: Array, normal: Array) -> Sequence[Array]:
    """Returns the points of (n, 3) that are the furthest in `DIRECTIONS` directions perpendicular to the
    normal."""
    if not len(points):
        return []
    angles = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    directions = np.stack([np.cos(angles), np.sin(angles)])
    furthest = np.unique((points @ _plane_axes(normal).T @ directions).argmax(axis=0))
    return [points[index] for index in furthest]


def _plane_axes(direction: Array) -> Array:
    """Returns two unit vectors (2, 3) perpendicular to a direction (3,) and to each other."""
    x_axis = np.cross(direction, np.eye(3)[np.abs(direction).argmin()])
    y_axis = np.cross(direction, x_axis)
    return np.stack([x_axis / np.linalg.norm(x_axis), y_axis / np.linalg.norm(y_axis)])
