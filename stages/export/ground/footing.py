"""Where a free robot stands at a pose: the points that touch the ground, and the weight that each carries."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.export.ground.extents import Extents
from linkwright.stages.robot.dynamics.statics import GroundSupport
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.poses import inverse, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.kinematics import link_poses

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.scene_section import GroundSection

NEAR = 2e-3
"""What is no further than this [m] above the ground touches it."""

CORNERS = 16
"""The points of a link that touch the ground are represented by those that lie furthest in this many
directions."""

EXACT = 1e-6
"""What a balance may be off, as a share of the weight times the size of the footing."""

_STRONG = 1e3
"""How much more the balance counts than the sum of squares, which chooses among the ways to share a
weight."""


def supports(
    robot: Robot,
    geometry: Geometry,
    world_from_root: Array,
    ground: "GroundSection",
    q: Configuration,
    up: Array,
) -> tuple[GroundSupport, ...]:
    """The points on which the robot stands at `q`, with its root link at `world_from_root`, where the forces
    of the ground, all of them along `up` (3,) [m/s², in the root link's axes], balance its weight: of all
    such forces those with the least sum of squares. Empty where the robot does not stand: nothing touches the
    ground, or the centre of mass is not above the points that do."""
    if ground.kind == "none" or not np.any(up):
        return ()
    contacts = list(touching(robot, geometry, world_from_root, ground, q))
    if not contacts:
        return ()
    links, points = zip(*contacts, strict=True)
    mass, center = mass_and_center(robot, q)
    shares = balanced(np.array(points), center, up)
    return tuple(
        GroundSupport(link, point, float(share * mass))
        for link, point, share in zip(links, points, shares, strict=True)
        if share > 0.0
    )


def balanced(points: Array, center: Array, up: Array) -> Array:
    """The share (n,) of a weight at `center` (3,) that each of the points (n, 3) carries, forces along `up`
    (3,); all zero where no forces that only push balance it.

    The least sum of squares under the balance of forces and moments: non-negative least squares (Lawson and
    Hanson, "Solving Least Squares Problems", chapter 23), in which the balance counts `_STRONG` times as
    much, and then exactly by the points that it chooses.
    """
    # Late: only robots that stand need it, and it takes a while to import.
    from scipy.optimize import nnls

    flat = (points - center) @ _across(up).T
    rows = np.vstack([np.ones(len(flat)), flat.T / max(float(np.abs(flat).max()), 1e-9)])
    wanted = np.array([1.0, 0.0, 0.0])
    rough, _ = nnls(
        np.vstack([_STRONG * rows, np.eye(len(flat))]),
        np.concatenate([_STRONG * wanted, np.zeros(len(flat))]),
    )
    # What is smaller is rounding, which differs between machines.
    used = rough > 0.1 * EXACT
    shares = np.zeros(len(flat))
    shares[used] = np.linalg.pinv(rows[:, used]) @ wanted
    off = np.abs(rows @ shares - wanted).max()
    stands = off <= EXACT and shares.min() >= -EXACT
    return np.maximum(shares, 0.0) if stands else np.zeros(len(flat))


def mass_and_center(robot: Robot, q: Configuration) -> tuple[float, Array]:
    """The mass [kg] of the whole robot at `q`, and its centre (3,) [m] in the root link's axes."""
    poses = link_poses(robot, q)
    mass = sum(link.inertial.mass for link in robot.links)
    moment = sum(
        link.inertial.mass * (poses[link.name] @ np.append(link.inertial.com, 1.0))[:3]
        for link in robot.links
    )
    return mass, moment / mass


def touching(
    robot: Robot, geometry: Geometry, world_from_root: Array, ground: "GroundSection", q: Configuration
) -> Iterator[tuple[str, Array]]:
    """(link, point (3,) [m] in the root link's axes) of the colliders on the ground."""
    normal = rotation_from_rpy(ground.rpy)[:, 2]
    poses = link_poses(robot, q)
    extents = Extents(geometry, {link: world_from_root @ pose for link, pose in poses.items()})
    root_from_world = inverse(world_from_root)
    limit = float(normal @ ground.xyz) + NEAR
    for link in robot.links:
        low = extents.below(link.name, "collision", normal, limit)
        for point in _corners(low, normal):
            yield link.name, (root_from_world @ np.append(point, 1.0))[:3]


def _corners(points: Array, normal: Array) -> Sequence[Array]:
    """Those of the points (n, 3) that lie furthest in `CORNERS` directions across the normal."""
    if not len(points):
        return []
    angles = 2 * np.pi * np.arange(CORNERS) / CORNERS
    directions = np.stack([np.cos(angles), np.sin(angles)])
    chosen = np.unique((points @ _across(normal).T @ directions).argmax(axis=0))
    return [points[index] for index in chosen]


def _across(direction: Array) -> Array:
    """Two unit vectors (2, 3) at right angles to a direction (3,) and to each other."""
    first = np.cross(direction, np.eye(3)[np.abs(direction).argmin()])
    second = np.cross(direction, first)
    return np.stack([first / np.linalg.norm(first), second / np.linalg.norm(second)])
