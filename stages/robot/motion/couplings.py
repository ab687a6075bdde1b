"""Finds the dofs that move together, by relations and closed loops, and can be driven at once.

In closed loops the speeds q̇ satisfy J q̇ = 0. With some of the dofs driven, the others follow them:
q̇ₚ = −Jₚ⁺ J_d q̇_d (Featherstone, "Rigid Body Dynamics Algorithms", 8.2: the null space as a map from
independent speeds). A dof that neither drives nor follows rests.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.pose_batch import Values, count_of

RANK_TOLERANCE = 1e-6
"""Singular values below this share of the largest count as zero: poses close to about 1e-8."""

SINGULAR_RATIO = 10.0
"""A pose is near a singular pose if its least singular value is this many times smaller than elsewhere."""

Rates = Mapping[str, Array]
"""Dof → its speeds (n, 1), for a ball (n, 3), at a unit speed of a driver."""


class Couplings:
    """A robot's couplings at configurations (n) whose loops are closed."""

    def __init__(self, robot: Robot, values: Values) -> None:
        shares = {relation.follower: (relation.driver, relation.multiplier) for relation in robot.relations}
        self._count = count_of(values)
        self._shares = shares
        self._followers: dict[str, list[tuple[str, float]]] = {}
        for follower, (driver, multiplier) in shares.items():
            self._followers.setdefault(driver, []).append((follower, multiplier))
        self._columns: Mapping[str, slice] = {}
        self._scales = np.zeros(0)
        self._jacobian = np.zeros((self._count, 0, 0))
        if robot.loops:
            closer = Closer(robot)
            self._columns, self._scales = closer.columns, closer.scales
            self._jacobian = closer.jacobian(values)

    @property
    def in_loops(self) -> frozenset[str]:
        """The dofs on which the closed loops depend, except followers."""
        return frozenset(self._columns)

    @property
    def coupled(self) -> frozenset[str]:
        """The dofs that move with others: those of loops and of relations."""
        return self.in_loops | self._shares.keys() | self._followers.keys()

    def independent(self, dofs: Iterable[str]) -> tuple[str, ...]:
        """Returns as many of the dofs as move independently of each other; earlier dofs are preferred."""
        chosen: list[str] = []
        drivers: set[str] = set()
        motions = self._motions()
        rows: list[int] = []
        for dof in dofs:
            driver, multiplier = self._shares.get(dof, (dof, 1.0))
            if driver in drivers or multiplier == 0.0:
                continue
            if driver in self._columns:
                columns = [*rows, self._columns[driver].start]
                # The basis has unit columns: singular values below this share are rounding.
                if np.linalg.matrix_rank(motions[columns], tol=RANK_TOLERANCE) < len(columns):
                    continue
                rows = columns
            drivers.add(driver)
            chosen.append(dof)
        return tuple(chosen)

    def _motions(self) -> Array:
        """Returns an orthonormal basis (size, k) of the speeds that keep the loops closed. It is that of the
        configuration with the fewest such speeds: others may be singular, with speeds that lead nowhere."""
        best = np.zeros((self._jacobian.shape[2], 0))
        for count, jacobian in enumerate(self._jacobian):
            _, sizes, across = np.linalg.svd(jacobian)
            rank = int((sizes > RANK_TOLERANCE * max(1.0, float(sizes[0]))).sum()) if sizes.size else 0
            if not count or len(across) - rank < best.shape[1]:
                best = across[rank:].T
        return best

    def near_singular(self, driven: Sequence[str]) -> dict[str, npt.NDArray[np.bool_]]:
        """Returns by driven dof of a loop whether its mechanism is near a singular pose, at each
        configuration (n,). There followers can move although the drivers rest, so a driver has an unbounded
        leverage (Gosselin and Angeles, "Singularity analysis of closed-loop kinematic chains", 1990: the
        second kind).

        The measure is the least singular value of the Jacobian of the followers, in shares of the ranges.
        """
        drivers = {dof: self._shares.get(dof, (dof, 1.0))[0] for dof in driven}
        driver_columns = {
            self._columns[driver].start for driver in drivers.values() if driver in self._columns
        }
        near_by_row: dict[int, npt.NDArray[np.bool_]] = {}
        for rows, columns in self._mechanisms():
            rest = [column for column in columns if column not in driver_columns]
            block = self._jacobian[:, rows][:, :, rest] * self._scales[rest]
            sizes = np.linalg.svd(block, compute_uv=False)
            ranks = (sizes > RANK_TOLERANCE * sizes.max(initial=0.0)).sum(axis=1)
            if not ranks.max(initial=0):
                continue
            least = sizes[:, ranks.max() - 1]
            near_by_row |= dict.fromkeys(columns, least * SINGULAR_RATIO < least.max())
        starts = {
            dof: self._columns[driver].start for dof, driver in drivers.items() if driver in self._columns
        }
        return {dof: near_by_row[start] for dof, start in starts.items() if start in near_by_row}

    def _mechanisms(self) -> list[tuple[list[int], list[int]]]:
        """Returns the rows and the columns of the Jacobian of each group of loops that share a dof."""
        groups: list[tuple[list[int], set[int]]] = []
        for first in range(0, self._jacobian.shape[1], 6):
            rows = list(range(first, first + 6))
            columns = set(np.flatnonzero(np.any(self._jacobian[:, rows], axis=(0, 1))).tolist())
            joined = [group for group in groups if group[1] & columns]
            groups = [group for group in groups if not group[1] & columns]
            rows = sorted([*rows, *(row for group in joined for row in group[0])])
            groups.append((rows, columns.union(*(group[1] for group in joined))))
        return [(rows, sorted(columns)) for rows, columns in groups]

    def moved_by(self, driven: Sequence[str]) -> dict[str, Rates]:
        """Returns the speeds of all dofs that move with each driven dof, itself included, while the other
        driven dofs rest."""
        drivers = {dof: self._shares.get(dof, (dof, 1.0)) for dof in driven}
        inside = [driver for driver, _ in drivers.values() if driver in self._columns]
        driver_columns = [self._columns[driver].start for driver in inside]
        rest = [column for column in range(self._jacobian.shape[2]) if column not in driver_columns]
        answers = np.zeros((self._count, len(rest), len(driver_columns)))
        if driver_columns and rest:
            back = np.linalg.pinv(self._jacobian[:, :, rest], rcond=RANK_TOLERANCE)
            answers = -back @ self._jacobian[:, :, driver_columns]
        rates_by_driver: dict[str, Rates] = {}
        for dof, (driver, multiplier) in drivers.items():
            rates = {driver: np.ones((self._count, 1))}
            if driver in self._columns:
                columns = np.zeros((self._count, self._jacobian.shape[2]))
                columns[:, rest] = answers[:, :, inside.index(driver)]
                columns[:, self._columns[driver]] = 1.0
                rates = {name: columns[:, part] for name, part in self._columns.items()}
            for name, speeds in list(rates.items()):
                rates |= {follower: factor * speeds for follower, factor in self._followers.get(name, ())}
            rates_by_driver[dof] = {name: speeds / (multiplier or 1.0) for name, speeds in rates.items()}
        return rates_by_driver


def nearest_first(robot: Robot) -> list[str]:
    """Returns the names of the tree's dofs, those nearest to the root first; at the same depth, those that
    move the most mass first."""
    depth = {robot.root.name: 0}
    order: dict[str, tuple[int, float, int]] = {}
    masses = {link.name: link.inertial.mass for link in robot.links}
    for joint in reversed(robot.joints):
        masses[joint.parent] += masses[joint.child]
    for number, joint in enumerate(robot.joints):
        depth[joint.child] = depth[joint.parent] + 1
        # Rounded to few digits, so that the same links on both sides count as equal.
        place = depth[joint.child], -float(f"{masses[joint.child]:.6g}"), number
        order |= {dof.name: place for dof in joint.dofs}
    return sorted(order, key=lambda name: order[name])
