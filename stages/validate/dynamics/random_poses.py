"""Seeded poses and speeds at which formats are compared: of the tree, whose loops are open there."""

import math

import numpy as np

from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.validate.dynamics.tree_dynamics import scalar_dofs

POSES = 100
SEED = 31415

PLACED = 20_000
"""The most links times poses: a larger robot is compared at fewer poses, and each has more links."""

FEWEST = 10

REACH = {"turn": math.pi, "slide": 1.0}
"""How far [rad, m] to both sides of zero, or from its one end, a range without ends goes."""


def samples(robot: Robot) -> tuple[dict[str, Array], Array]:
    """Values (n, ...) of every dof of the tree, within limits, and speeds (n, k) of its turns and slides up
    to 1 rad/s or m/s. n is `POSES`, less for a robot of more than 200 links."""
    random = np.random.Generator(np.random.PCG64(SEED))
    poses = max(FEWEST, min(POSES, PLACED // len(robot.links)))
    values: dict[str, Array] = {}
    for dof in robot.dofs:
        if dof.kind in REACH:
            low, high = dof.limits.interval
            reach = REACH[dof.kind]
            low = min(-reach, high - reach) if math.isinf(low) else low
            high = max(reach, low + reach) if math.isinf(high) else high
            values[dof.name] = random.uniform(low, high, poses)
            continue
        quats = random.normal(size=(poses, 4))
        quats /= np.linalg.norm(quats, axis=1)[:, None]
        places = random.uniform(-1, 1, (poses, 3))
        values[dof.name] = quats if dof.kind == "ball" else np.concatenate([places, quats], axis=1)
    return values, random.uniform(-1, 1, (poses, len(scalar_dofs(robot))))
