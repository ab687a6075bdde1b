"""Draws random poses of a robot that satisfy its limits, relations and loops, the same every time."""

import hashlib
import math

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Robot, Value
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.pose_batch import count_of, repeated, select

_ROUNDS = 4
"""Largest number of times that a pose is drawn until its loops close."""

_COSINE_TOLERANCE = 1e-9
"""Tolerance of the cosine of a ball's tilt, for rounding: a drawn pose may be on the edge of the cone."""

_STEPS = 24
"""Number of steps from the start to a drawn pose; the loops are closed in each."""


def sampled_poses(
    robot: Robot, count: int, reach: float, start: Configuration, salt: str = ""
) -> dict[str, Array]:
    """Returns `count` configurations of all dofs, the same every time: arrays as `pose_batch.Values`. Another
    `salt` draws independent configurations.

    The value of a turn or slide is uniform in its range, from a generator (PCG64) that the name of the dof
    seeds, so that the order of joints does not matter. A turn without limits ranges half a turn to both sides
    of its value in `start`, a slide or free motion `reach` [m]. With a single limit the range is as long,
    from that limit on. The z axis of a ball is uniform in the cone, and the turn about that axis is uniform.
    Followers follow their drivers.

    The dofs of loops move from `start`, whose loops must be closed, as near to the drawn values as closed
    loops allow. A pose whose loops do not close is drawn again, at most three times, so there may be fewer
    poses or none.
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
    starts = repeated({name: start[name] for name in _loop_dofs(robot, closer)}, count)
    batches: list[dict[str, Array]] = []
    for attempt in range(_ROUNDS):
        target = select(all_values, np.arange(attempt * count, (attempt + 1) * count))
        begin = {**target, **starts}
        values, closed = closer.settled(closer.towards(begin, target, _STEPS))
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
    """Returns `_ROUNDS` times `count` values of a dof. `limits`: its range, None for a ball and for free
    motion; `middle`: its value in the start pose."""
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
    """Returns the lower and the upper end of a range. Two open ends are `reach` from `middle`; a single open
    end is twice that from the other end."""
    low, high = limits
    if math.isinf(low) and math.isinf(high):
        return middle - reach, middle + reach
    if math.isinf(low):
        return high - 2 * reach, high
    return low, low + 2 * reach if math.isinf(high) else high


def _quats(random: Array, cone: float) -> Array:
    """Returns rotations as quaternions (n, 4), whose z axis is uniform in a cone of the half angle `cone`
    [rad]. `random`: three uniform numbers in 0..1 for each (n, 3)."""
    # The area of a cap of a sphere grows with 1 − cos(tilt), so the cosine is drawn evenly.
    tilt = np.arccos(1 - random[:, 0] * (1 - math.cos(min(cone, math.pi))))
    direction, twist = 2 * math.pi * random[:, 1], 2 * math.pi * random[:, 2]
    # Rz(direction) Ry(tilt) Rz(twist - direction): the z axis is tilted towards `direction`.
    half_tilt, half_twist, azimuth = tilt / 2, twist / 2, direction - twist / 2
    return np.column_stack(
        [
            np.cos(half_tilt) * np.cos(half_twist),
            np.sin(half_tilt) * -np.sin(azimuth),
            np.sin(half_tilt) * np.cos(azimuth),
            np.cos(half_tilt) * np.sin(half_twist),
        ]
    )


def _in_cones(dofs: list[Dof], values: dict[str, Array]) -> npt.NDArray[np.bool_]:
    """Returns for each configuration (n,) whether all balls are within their cones."""
    in_cone = np.ones(count_of(values), dtype=bool)
    for dof in dofs:
        if dof.kind == "ball" and dof.limits.upper is not None:
            _, x, y, _ = values[dof.name].T
            # The z component of the rotated z axis is 1 − 2 (x² + y²), the cosine of its tilt.
            in_cone &= 1 - 2 * (x * x + y * y) >= math.cos(min(dof.limits.upper, math.pi)) - _COSINE_TOLERANCE
    return in_cone
