"""Which dofs the closed loops make follow another one, and how nearly that is linear.

Along a closed loop every dof is a function of those that the loops leave free. From a pose with closed loops
the free ones are moved over their ranges in small steps, the loops being closed at each (predicted by the
last step, corrected by Newton's method), so that the mechanism stays on the way on which it began. A
straight line is then fitted to what each follower did, by least squares.
"""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.couplings import RANK, Couplings, Rates, nearest_first
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.linear_coupling import LinearCoupling
from linkwright.stages.robot.motion.loop_groups import LoopGroups
from linkwright.stages.robot.motion.pose_batch import Values, chosen, count_of, repeated
from linkwright.stages.robot.motion.pose_samples import ends_of

EXACT = 1e-9
"""A follower is on its line where it is never further off [rad or m]."""

_DIGITS = 11
"""Decimals of the numbers of a line: what two machines compute differs below these."""

_COARSE, _DENSE = 65, 257
"""Points of a driver's range: to fit lines, and to certify those that are exact."""

_STEPS = 16
"""Steps from the first pose to each point."""

_PATIENCE = 8
"""Steps of Newton's method in which one of these closes, but near a singular pose."""

_ENOUGH = 9
"""Points with closed loops that a line needs."""

_REACH = 1.0
"""How far a slide without limits goes to either side [m]; a turn makes half a turn."""


def linear_couplings(
    robot: Robot, start: Configuration, first: Sequence[str] = ()
) -> tuple[LinearCoupling, ...]:
    """The couplings of all loops, in the order of the dofs. None of loops that are not
    closed at `start`, or that can go on from there in several ways.

    As many dofs as the loops leave free are drivers: the `first` ones where they can be, then the nearest to
    the root. Where there are several, a follower's driver is the one whose line fits best.
    """
    if not robot.loops:
        return ()
    order = {name: place for place, name in enumerate(dict.fromkeys((*first, *nearest_first(robot))))}
    mechanisms = LoopGroups(robot).mechanisms()
    found = [coupling for one in mechanisms for coupling in _of_mechanism(one, start, order)]
    places = {dof.name: place for place, dof in enumerate(robot.dofs)}
    return tuple(sorted(found, key=lambda coupling: places[coupling.follower]))


def closed_loops(robot: Robot, couplings: Sequence[LinearCoupling]) -> tuple[str, ...]:
    """The loops that the exact couplings alone keep closed: all dofs on their ways drive or follow."""
    exact = [one for one in couplings if one.exact]
    followers = {one.follower for one in exact}
    known = followers | {one.driver for one in exact}
    groups, found = LoopGroups(robot), []
    for loop in robot.loops:
        moved = groups.moved_by(loop) - {dof.name for dof in loop.dofs}
        if moved <= known and moved & followers:
            found.append(loop.name)
    return tuple(found)


def _of_mechanism(robot: Robot, start: Configuration, places: Mapping[str, int]) -> Iterator[LinearCoupling]:
    """The couplings of a robot whose loops are all connected. `places`: which dofs shall drive first."""
    closer = Closer(robot)
    scalars = {dof.name for dof in robot.dofs if dof.kind in ("turn", "slide")} & set(closer.names)
    order = sorted(scalars, key=places.__getitem__)
    every = {dof.name for dof in (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs))}
    begin, closed = closer.settled(repeated({name: start[name] for name in every}, 1))
    if not closed[0]:
        return
    couplings = Couplings(robot, begin)
    drivers = couplings.independent(order)
    determined = _determined(closer, begin, drivers)
    followers = [name for name in order if name in determined and name not in drivers]
    if not drivers or not followers:
        return
    rates = couplings.moved_by(drivers)
    path = _path(robot, begin, rates, _COARSE)
    if _singular(closer, begin, path):
        return
    lines = _lines(followers, drivers, path)
    if any(line.exact for line in lines):
        lines = _lines(followers, drivers, _path(robot, begin, rates, _DENSE))
    yield from lines


def _singular(closer: Closer, begin: Values, path: Values) -> bool:
    """Whether more can move at `begin` than along the path, as of a parallelogram that lies flat: then it has
    several ways to go on, of which the path is one. So it is where there is no path."""
    first, along = (_ranks(closer.jacobian(values)) for values in (begin, path))
    return not along.size or bool(first.max() < along.max())


def _ranks(jacobian: Array) -> npt.NDArray[np.intp]:
    sizes = np.linalg.svd(jacobian, compute_uv=False)
    ranks: npt.NDArray[np.intp] = (sizes > RANK * np.maximum(1.0, sizes[:, :1])).sum(axis=1)
    return ranks


def _determined(closer: Closer, values: Values, drivers: Sequence[str]) -> set[str]:
    """The dofs that cannot move while the drivers rest."""
    jacobian = closer.jacobian(values)[0]
    held = [closer.columns[driver].start for driver in drivers]
    rest = [column for column in range(jacobian.shape[1]) if column not in held]
    if not rest:
        return set()
    _, sizes, across = np.linalg.svd(jacobian[:, rest])
    rank = int((sizes > RANK * max(1.0, float(sizes[0]))).sum())
    free = np.zeros(jacobian.shape[1])
    free[rest] = np.linalg.norm(across[rank:], axis=0)
    return {name for name, part in closer.columns.items() if float(free[part].max()) < RANK}


def _path(robot: Robot, begin: Values, rates: Mapping[str, Rates], points: int) -> dict[str, Array]:
    """Closed configurations: of each driver `points` over its range while the others stay, and where there
    are several, as many with all of them anywhere. Those are left out that limits or the loops forbid."""
    targets = _targets(robot, begin, list(rates), points)
    closer = Closer(robot, held=list(rates))
    count = len(next(iter(targets.values())))
    now: dict[str, Array] = {name: np.repeat(value, count, axis=0) for name, value in begin.items()}
    moves = {name: np.zeros(count) for name, value in now.items() if value.ndim == 1}
    for driver, speeds in rates.items():
        step = (targets[driver] - now[driver]) / _STEPS
        for name, speed in speeds.items():
            if name in moves:
                moves[name] += float(speed[0, 0]) * step
    for _ in range(_STEPS):
        ahead = {**now, **{name: now[name] + move for name, move in moves.items()}}
        after, closed = closer.settled(ahead, _PATIENCE)
        moves = {name: (after[name] - now[name])[closed] for name in moves}
        now = dict(chosen(after, closed))
        if not closed.any():
            break
    return now


def _targets(robot: Robot, begin: Values, drivers: Sequence[str], points: int) -> dict[str, Array]:
    """Values of the drivers."""
    limits = ranges(robot)
    kinds = {dof.name: dof.kind for dof in robot.dofs}
    ends = {
        name: ends_of(limits[name], float(begin[name][0]), math.pi if kinds[name] == "turn" else _REACH)
        for name in drivers
    }
    rows = [
        {**{name: np.full(points, begin[name][0]) for name in drivers}, one: np.linspace(*ends[one], points)}
        for one in drivers
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
    """Of each follower the line that fits best."""
    if count_of(values) < _ENOUGH:
        return []
    return [
        min((_line(name, driver, values) for driver in drivers), key=lambda line: line.error)
        for name in followers
    ]


def _line(follower: str, driver: str, values: Mapping[str, Array]) -> LinearCoupling:
    x, y = values[driver], values[follower]
    slope, height = np.linalg.lstsq(np.column_stack([x, np.ones_like(x)]), y, rcond=None)[0]
    slope, height = round(float(slope), _DIGITS) + 0.0, round(float(height), _DIGITS) + 0.0
    error = float(np.abs(y - (slope * x + height)).max())
    exact = error <= EXACT
    return LinearCoupling(follower, driver, slope, height, error, exact, float(x.min()), float(x.max()))
