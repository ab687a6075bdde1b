"""Draws seeded poses and speeds of the tree, with loops left open, at which formats are compared."""

import math

import numpy as np

from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.validate.dynamics.tree_dynamics import scalar_dofs

POSES = 100
"""Largest number of poses."""

SEED = 31415
"""An arbitrary seed, so that the poses are the same in every run."""

MAX_LINK_POSES = 20_000
"""Largest product of links and poses: larger robots are compared at fewer poses."""

MIN_POSES = 10
"""Smallest number of poses, however large the robot is."""

OPEN_EXTENT = {"turn": math.pi, "slide": 1.0}
"""Extent [rad, m] of a range without limits: to both sides of zero, or from its only limit."""


def poses_and_speeds(robot: Robot) -> tuple[dict[str, Array], Array]:
    """Returns values (n, ...) of every dof of the tree within limits, and speeds (n, k) up to 1 rad/s or m/s
    of its turns and slides. n is `POSES`, or less for a robot with more than 200 links."""
    random = np.random.Generator(np.random.PCG64(SEED))
    poses = max(MIN_POSES, min(POSES, MAX_LINK_POSES // len(robot.links)))
    values: dict[str, Array] = {}
    for dof in robot.dofs:
        if dof.kind in OPEN_EXTENT:
            low, high = dof.limits.interval
            reach = OPEN_EXTENT[dof.kind]
            low = min(-reach, high - reach) if math.isinf(low) else low
            high = max(reach, low + reach) if math.isinf(high) else high
            values[dof.name] = random.uniform(low, high, poses)
            continue
        quats = random.normal(size=(poses, 4))
        quats /= np.linalg.norm(quats, axis=1)[:, None]
        places = random.uniform(-1, 1, (poses, 3))
        values[dof.name] = quats if dof.kind == "ball" else np.concatenate([places, quats], axis=1)
    return values, random.uniform(-1, 1, (poses, len(scalar_dofs(robot))))
