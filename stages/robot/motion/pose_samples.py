"""Draws seeded poses of a robot that satisfy its limits, relations and loops."""

import hashlib
import math

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Robot, Value
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.pose_batch import count_of, repeated, select

_ROUNDS = 4
"""Largest number of draws of a pose until its loops close."""

_STEPS = 24
"""Steps from `home` to a drawn pose, at each of which the loops are closed."""


def sampled_poses(
    robot: Robot, count: int, reach: float, start: Configuration, salt: str = ""
) -> dict[str, Array]:
    """Returns `count` configurations of all dofs, the same every time: arrays as `pose_batch.Values`. Another
    `salt` draws independent configurations.

    Every scalar is drawn evenly from its range, seeded by its dof's name (PCG64), so that the order of joints
    does not matter. A turn without limits makes the whole turn about its value in `start`; a slide, or free
    motion, goes as far as `reach` [m] to both sides of it; with a single limit the range is as long. A ball's
    z axis points evenly into its cone, and the ball turns about it by any angle. Followers follow.

    Where a robot has loops, the dofs of these move from `start`, at which the loops must be closed, as near
    to the drawn values as closed loops allow; a pose whose loops do not close is drawn again, at most three
    times: there may be fewer poses then, or none.
    """
    dofs = [*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs)]
    limits = ranges(robot)
    all_values = {
        dof.name: _draw(dof, limits.get(dof.name), start[dof.name], reach, count, salt) for dof in dofs
    }
    for relation in robot.relations:
        all_values[relation.follower] = relation.multiplier * all_values[relation.driver] + relation.offset
    if not robot.loops:
        return select(all_values, np.arange(count))
    closer = Closer(robot)
    batches: list[dict[str, Array]] = []
    for turn in range(_ROUNDS):
        target = select(all_values, np.arange(turn * count, (turn + 1) * count))
        first = {**target, **{name: repeated(start, count)[name] for name in _loop_dofs(robot, closer)}}
        values, closed = closer.settled(closer.towards(first, target, _STEPS))
        batches.append(select(values, closed & _in_cones(dofs, values)))
        if sum(map(count_of, batches)) >= count:
            break
    return {name: np.concatenate([values[name] for values in batches])[:count] for name in all_values}


def _loop_dofs(robot: Robot, closer: Closer) -> set[str]:
    """Returns the dofs that the loops move, and their followers."""
    moved = set(closer.names)
    return moved | {relation.follower for relation in robot.relations if relation.driver in moved}


def _draw(
    dof: Dof, limits: tuple[float, float] | None, middle: Value, reach: float, count: int, salt: str
) -> Array:
    """Returns `_ROUNDS` times `count` values of a dof."""
    seed = int.from_bytes(hashlib.sha256(f"{salt}{dof.name}".encode()).digest()[:16], "big")
    random = np.random.Generator(np.random.PCG64(seed)).random((_ROUNDS * count, 6))
    if limits is not None and not isinstance(middle, tuple):
        low, high = ends_of(limits, middle, math.pi if dof.kind == "turn" else reach)
        return low + random[:, 0] * (high - low)
    quats = _quats(random[:, :3], math.pi if dof.limits.upper is None else dof.limits.upper)
    if dof.kind == "ball":
        return quats
    assert isinstance(middle, tuple)
    return np.concatenate([np.array(middle[:3]) + reach * (2 * random[:, 3:] - 1), quats], axis=1)


def ends_of(limits: tuple[float, float], middle: float, reach: float) -> tuple[float, float]:
    """Returns both ends of a range: an open end is `reach` from `middle`, or twice that from the other
    end."""
    low, high = limits
    if math.isinf(low) and math.isinf(high):
        return middle - reach, middle + reach
    if math.isinf(low):
        return high - 2 * reach, high
    return low, low + 2 * reach if math.isinf(high) else high


def _quats(random: Array, cone: float) -> Array:
    """Returns rotations whose z axis is evenly spread over a cone of this half angle [rad], as quaternions
    (n, 4)."""
    # The area of a cap of a sphere grows with 1 − cos(tilt), so the cosine is drawn evenly.
    tilt = np.arccos(1 - random[:, 0] * (1 - math.cos(min(cone, math.pi))))
    turn, about = 2 * math.pi * random[:, 1], 2 * math.pi * random[:, 2]
    # Rz(turn) Ry(tilt) Rz(about - turn): the z axis points along `turn`, and `about` is the twist.
    half, plus, minus = tilt / 2, about / 2, turn - about / 2
    return np.column_stack(
        [
            np.cos(half) * np.cos(plus),
            np.sin(half) * -np.sin(minus),
            np.sin(half) * np.cos(minus),
            np.cos(half) * np.sin(plus),
        ]
    )


def _in_cones(dofs: list[Dof], values: dict[str, Array]) -> npt.NDArray[np.bool_]:
    """Returns whether every ball (n,) is within its cone."""
    in_cone = np.ones(count_of(values), dtype=bool)
    for dof in dofs:
        if dof.kind == "ball" and dof.limits.upper is not None:
            _, x, y, _ = values[dof.name].T
            # The turned z axis has the z component 1 − 2 (x² + y²), the cosine of its tilt.
            in_cone &= 1 - 2 * (x * x + y * y) >= math.cos(min(dof.limits.upper, math.pi)) - 1e-9
    return in_cone
