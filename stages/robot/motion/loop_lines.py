"""Finds the dofs that follow other dofs because of closed loops, and fits straight lines to their motion.

Along a closed loop every dof is a function of the dofs that the loops leave free. From a pose with closed
loops the free dofs are moved over their ranges in small steps, the loops being closed at each (predicted by
the last step, corrected by Newton's method), so that the mechanism stays on its branch. A straight line is
then fitted to the motion of each follower, by least squares.
"""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.couplings import RANK_TOLERANCE, Couplings, Rates, nearest_first
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.linear_coupling import LinearCoupling
from linkwright.stages.robot.motion.loop_groups import LoopGroups
from linkwright.stages.robot.motion.pose_batch import Values, count_of, repeated, select
from linkwright.stages.robot.motion.pose_samples import ends_of

EXACT_TOLERANCE = 1e-9
"""Largest error [rad or m] of an exact line."""

_DIGITS = 11
"""Number of decimals of a line's numbers: further decimals differ between machines."""

_COARSE_POINTS, _DENSE_POINTS = 65, 257
"""Number of points of a driver's range to fit lines, and to confirm exact lines."""

_STEPS = 16
"""Number of steps from the first pose to each point."""

_MAX_NEWTON_STEPS = 8
"""Largest number of steps of Newton's method in which the loops close, except near a singular pose."""

_MIN_POINTS = 9
"""Smallest number of points with closed loops to which a line is fitted."""

_SLIDE_REACH = 1.0
"""The motion [m] of a slide without limits to either side; that of a turn is half a turn."""


def linear_couplings(
    robot: Robot, start: Configuration, first: Sequence[str] = ()
) -> tuple[LinearCoupling, ...]:
    """Returns the couplings of all loops, in the order of the dofs. Loops that are not closed at `start`, or
    that can go on from there in several ways, have no couplings.

    The drivers are as many dofs as the loops leave free: those in `first` if possible, then the nearest to
    the root. A follower gets the driver whose line fits best.
    """
    if not robot.loops:
        return ()
    order = {name: place for place, name in enumerate(dict.fromkeys((*first, *nearest_first(robot))))}
    mechanisms = LoopGroups(robot).mechanisms()
    couplings = [
        coupling for mechanism in mechanisms for coupling in _mechanism_couplings(mechanism, start, order)
    ]
    places = {dof.name: place for place, dof in enumerate(robot.dofs)}
    return tuple(sorted(couplings, key=lambda coupling: places[coupling.follower]))


def closed_loops(robot: Robot, couplings: Sequence[LinearCoupling]) -> tuple[str, ...]:
    """Returns the names of the loops that the exact couplings keep closed: all dofs on their paths are
    drivers or followers, and at least one follows."""
    exact = [coupling for coupling in couplings if coupling.exact]
    followers = {coupling.follower for coupling in exact}
    coupled = followers | {coupling.driver for coupling in exact}
    groups, closed = LoopGroups(robot), []
    for loop in robot.loops:
        tree_dofs = groups.dofs_of(loop) - {dof.name for dof in loop.dofs}
        if tree_dofs <= coupled and tree_dofs & followers:
            closed.append(loop.name)
    return tuple(closed)


def _mechanism_couplings(
    robot: Robot, start: Configuration, places: Mapping[str, int]
) -> Iterator[LinearCoupling]:
    """Yields the couplings of a robot whose loops are a single group (see `LoopGroups`). `places`: dof → its
    place in the order of preference as driver."""
    closer = Closer(robot)
    scalars = {dof.name for dof in robot.dofs if dof.kind in ("turn", "slide")} & set(closer.names)
    order = sorted(scalars, key=places.__getitem__)
    all_names = {dof.name for dof in (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs))}
    begin, closed = closer.settled(repeated({name: start[name] for name in all_names}, 1))
    if not closed[0]:
        return
    couplings = Couplings(robot, begin)
    drivers = couplings.independent(order)
    determined = _determined_dofs(closer, begin, drivers)
    followers = [name for name in order if name in determined and name not in drivers]
    if not drivers or not followers:
        return
    rates = couplings.moved_by(drivers)
    path = _path(robot, begin, rates, _COARSE_POINTS)
    if _is_singular(closer, begin, path):
        return
    lines = _lines(followers, drivers, path)
    if any(line.exact for line in lines):
        lines = _lines(followers, drivers, _path(robot, begin, rates, _DENSE_POINTS))
    yield from lines


def _is_singular(closer: Closer, begin: Values, path: Values) -> bool:
    """Returns whether the loops allow more motions at `begin` than on the path, like a flat parallelogram.
    The mechanism can then go on in several ways, and the path is only one of them. Returns True for an empty
    path."""
    begin_ranks, path_ranks = (_ranks(closer.jacobian(values)) for values in (begin, path))
    return not path_ranks.size or bool(begin_ranks.max() < path_ranks.max())


def _ranks(jacobian: Array) -> npt.NDArray[np.intp]:
    """Returns the ranks (n,) of Jacobians (n, rows, columns)."""
    singular_values = np.linalg.svd(jacobian, compute_uv=False)
    smallest = RANK_TOLERANCE * np.maximum(1.0, singular_values[:, :1])
    ranks: npt.NDArray[np.intp] = (singular_values > smallest).sum(axis=1)
    return ranks


def _determined_dofs(closer: Closer, values: Values, drivers: Sequence[str]) -> set[str]:
    """Returns the dofs that cannot move while the drivers rest."""
    jacobian = closer.jacobian(values)[0]
    driver_columns = [closer.columns[driver].start for driver in drivers]
    rest = [column for column in range(jacobian.shape[1]) if column not in driver_columns]
    if not rest:
        return set()
    _, singular_values, right_vectors = np.linalg.svd(jacobian[:, rest])
    rank = int((singular_values > RANK_TOLERANCE * max(1.0, float(singular_values[0]))).sum())
    # How far each column takes part in the motions that remain.
    mobility = np.zeros(jacobian.shape[1])
    mobility[rest] = np.linalg.norm(right_vectors[rank:], axis=0)
    return {name for name, part in closer.columns.items() if float(mobility[part].max()) < RANK_TOLERANCE}


def _path(robot: Robot, begin: Values, rates: Mapping[str, Rates], points: int) -> dict[str, Array]:
    """Returns closed configurations: `points` over the range of each driver while the others rest and, for
    several drivers, as many with all of them at random values. Those that limits or the loops forbid are left
    out."""
    targets = _targets(robot, begin, list(rates), points)
    closer = Closer(robot, held=list(rates))
    count = len(next(iter(targets.values())))
    current: dict[str, Array] = {name: np.repeat(value, count, axis=0) for name, value in begin.items()}
    # The first step is predicted by the rates; a ball is not predicted.
    last_steps = {name: np.zeros(count) for name, value in current.items() if value.ndim == 1}
    for driver, speeds in rates.items():
        step = (targets[driver] - current[driver]) / _STEPS
        for name, speed in speeds.items():
            if name in last_steps:
                last_steps[name] += float(speed[0, 0]) * step
    for _ in range(_STEPS):
        ahead = {**current, **{name: current[name] + move for name, move in last_steps.items()}}
        after, closed = closer.settled(ahead, _MAX_NEWTON_STEPS)
        last_steps = {name: (after[name] - current[name])[closed] for name in last_steps}
        current = dict(select(after, closed))
        if not closed.any():
            break
    return current


def _targets(robot: Robot, begin: Values, drivers: Sequence[str], points: int) -> dict[str, Array]:
    """Returns the target values of the drivers, as described for `_path`."""
    limits = ranges(robot)
    kinds = {dof.name: dof.kind for dof in robot.dofs}
    ends = {
        name: ends_of(limits[name], float(begin[name][0]), math.pi if kinds[name] == "turn" else _SLIDE_REACH)
        for name in drivers
    }
    rows = [
        {
            **{name: np.full(points, begin[name][0]) for name in drivers},
            moved: np.linspace(*ends[moved], points),
        }
        for moved in drivers
    ]
    if len(drivers) > 1:
        random = np.random.Generator(np.random.PCG64(len(drivers))).random((len(drivers), points))
        rows.append(
            {name: low + share * (high - low) for (name, (low, high)), share in zip(ends.items(), random)}
        )
    return {name: np.concatenate([row[name] for row in rows]) for name in drivers}


def _lines(
    followers: Sequence[str], drivers: Sequence[str], values: Mapping[str, Array]
) -> list[LinearCoupling]:
    """Returns for each follower the line that fits best; nothing for fewer than `_MIN_POINTS`
    configurations."""
    if count_of(values) < _MIN_POINTS:
        return []
    return [
        min((_line(name, driver, values) for driver in drivers), key=lambda line: line.error)
        for name in followers
    ]


def _line(follower: str, driver: str, values: Mapping[str, Array]) -> LinearCoupling:
    """Returns the line of a follower over a driver, by least squares."""
    x, y = values[driver], values[follower]
    slope, offset = np.linalg.lstsq(np.column_stack([x, np.ones_like(x)]), y, rcond=None)[0]
    # Adding 0.0 turns -0.0 into 0.0.
    slope, offset = round(float(slope), _DIGITS) + 0.0, round(float(offset), _DIGITS) + 0.0
    error = float(np.abs(y - (slope * x + offset)).max())
    return LinearCoupling(
        follower,
        driver,
        multiplier=slope,
        offset=offset,
        error=error,
        exact=error <= EXACT_TOLERANCE,
        low=float(x.min()),
        high=float(x.max()),
    )
