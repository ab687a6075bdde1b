"""Finds the dofs that move together by relations and closed loops, and those that can be driven
independently.

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
"""Share of the largest singular value below which a singular value counts as zero. Loops are closed to about
1e-8."""

SINGULAR_RATIO = 10.0
"""A pose is near a singular pose if its least singular value, times this ratio, is below that of another
pose."""

_ROWS_PER_LOOP = 6
"""Rows of the Jacobian for a loop: three of position, three of orientation."""

Rates = Mapping[str, Array]
"""Dof → its speeds (n, 1), for a ball (n, 3), at a unit speed of a driven dof."""


class Couplings:
    """The couplings of a robot at n configurations."""

    def __init__(self, robot: Robot, values: Values) -> None:
        """`values`: configurations with closed loops."""
        self._count = count_of(values)
        self._drivers = {
            relation.follower: (relation.driver, relation.multiplier) for relation in robot.relations
        }
        """Follower → its driver, and the multiplier."""
        self._followers: dict[str, list[tuple[str, float]]] = {}
        for follower, (driver, multiplier) in self._drivers.items():
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
        return self.in_loops | self._drivers.keys() | self._followers.keys()

    def independent(self, dofs: Iterable[str]) -> tuple[str, ...]:
        """Returns the largest choice of these dofs that move independently of each other; earlier dofs are
        preferred. A dof that follows another with the multiplier 0 is never chosen."""
        chosen: list[str] = []
        used_drivers: set[str] = set()
        motions = self._motions()
        rows: list[int] = []
        for dof in dofs:
            driver, multiplier = self._drive_of(dof)
            if driver in used_drivers or multiplier == 0.0:
                continue
            if driver in self._columns:
                # Rows of `motions` belong to the columns of the Jacobian.
                more_rows = [*rows, self._columns[driver].start]
                # The basis is orthonormal, so the tolerance needs no scale.
                if np.linalg.matrix_rank(motions[more_rows], tol=RANK_TOLERANCE) < len(more_rows):
                    continue
                rows = more_rows
            used_drivers.add(driver)
            chosen.append(dof)
        return tuple(chosen)

    def _drive_of(self, dof: str) -> tuple[str, float]:
        """Returns the driver of a dof and the multiplier; the dof itself and 1 if it follows no other dof."""
        return self._drivers.get(dof, (dof, 1.0))

    def _motions(self) -> Array:
        """Returns an orthonormal basis (size, k) of the speeds that keep the loops closed, at the
        configuration with the fewest such speeds. Other configurations may be singular and have speeds that
        lead nowhere."""
        basis = np.zeros((self._jacobian.shape[2], 0))
        for index, jacobian in enumerate(self._jacobian):
            _, singular_values, right_vectors = np.linalg.svd(jacobian)
            largest = max(1.0, float(singular_values.max(initial=0.0)))
            rank = int((singular_values > RANK_TOLERANCE * largest).sum())
            if index == 0 or len(right_vectors) - rank < basis.shape[1]:
                basis = right_vectors[rank:].T
        return basis

    def near_singular(self, driven: Sequence[str]) -> dict[str, npt.NDArray[np.bool_]]:
        """Returns for each driven dof of a loop whether (n,) its mechanism is near a singular pose. There the
        other dofs can move although the driven dofs rest, so that these have an unbounded leverage (Gosselin
        and Angeles, "Singularity analysis of closed-loop kinematic chains", 1990: the second kind).

        The measure is the least singular value of the Jacobian by the other dofs, in units of
        `Closer.scales`.
        """
        driver_of = {dof: self._drive_of(dof)[0] for dof in driven}
        # Driven dofs are turns and slides, so each has a single column.
        driver_columns = {
            self._columns[driver].start for driver in driver_of.values() if driver in self._columns
        }
        is_near_by_column: dict[int, npt.NDArray[np.bool_]] = {}
        for rows, columns in self._mechanisms():
            rest = [column for column in columns if column not in driver_columns]
            block = self._jacobian[:, rows][:, :, rest] * self._scales[rest]
            singular_values = np.linalg.svd(block, compute_uv=False)
            ranks = (singular_values > RANK_TOLERANCE * singular_values.max(initial=0.0)).sum(axis=1)
            if not ranks.max(initial=0):
                continue
            least = singular_values[:, ranks.max() - 1]
            is_near_by_column |= dict.fromkeys(columns, least * SINGULAR_RATIO < least.max())
        starts = {
            dof: self._columns[driver].start for dof, driver in driver_of.items() if driver in self._columns
        }
        return {dof: is_near_by_column[start] for dof, start in starts.items() if start in is_near_by_column}

    def _mechanisms(self) -> list[tuple[list[int], list[int]]]:
        """Returns the rows and the columns of the Jacobian of each group of loops that share a dof."""
        groups: list[tuple[list[int], set[int]]] = []
        for first in range(0, self._jacobian.shape[1], _ROWS_PER_LOOP):
            rows = list(range(first, first + _ROWS_PER_LOOP))
            columns = set(np.flatnonzero(np.any(self._jacobian[:, rows], axis=(0, 1))).tolist())
            joined = [group for group in groups if group[1] & columns]
            groups = [group for group in groups if not group[1] & columns]
            rows = sorted([*rows, *(row for group in joined for row in group[0])])
            groups.append((rows, columns.union(*(group[1] for group in joined))))
        return [(rows, sorted(columns)) for rows, columns in groups]

    def moved_by(self, driven: Sequence[str]) -> dict[str, Rates]:
        """Returns by driven dof the speeds of all dofs that move with it, its own included, at its unit speed
        while the other driven dofs rest."""
        drive_of = {dof: self._drive_of(dof) for dof in driven}
        inside = [driver for driver, _ in drive_of.values() if driver in self._columns]
        # Driven dofs are turns and slides, so each has a single column.
        driver_columns = [self._columns[driver].start for driver in inside]
        rest = [column for column in range(self._jacobian.shape[2]) if column not in driver_columns]
        responses = np.zeros((self._count, len(rest), len(driver_columns)))
        if driver_columns and rest:
            inverses = np.linalg.pinv(self._jacobian[:, :, rest], rcond=RANK_TOLERANCE)
            responses = -inverses @ self._jacobian[:, :, driver_columns]
        rates_by_dof: dict[str, Rates] = {}
        for dof, (driver, multiplier) in drive_of.items():
            rates = {driver: np.ones((self._count, 1))}
            if driver in self._columns:
                columns = np.zeros((self._count, self._jacobian.shape[2]))
                columns[:, rest] = responses[:, :, inside.index(driver)]
                columns[:, self._columns[driver]] = 1.0
                rates = {name: columns[:, part] for name, part in self._columns.items()}
            for name, speeds in list(rates.items()):
                rates |= {follower: factor * speeds for follower, factor in self._followers.get(name, ())}
            # At a unit speed of the dof itself, and not of its driver.
            rates_by_dof[dof] = {name: speeds / (multiplier or 1.0) for name, speeds in rates.items()}
        return rates_by_dof


def nearest_first(robot: Robot) -> list[str]:
    """Returns the names of the tree's dofs, the nearest to the root first; at the same depth those that move
    the most mass first, else in the order of the joints."""
    depth = {robot.root.name: 0}
    order: dict[str, tuple[int, float, int]] = {}
    masses = {link.name: link.inertial.mass for link in robot.links}
    # The joints of a robot are in an order from the root on: parents come before their children.
    for joint in reversed(robot.joints):
        masses[joint.parent] += masses[joint.child]
    for number, joint in enumerate(robot.joints):
        depth[joint.child] = depth[joint.parent] + 1
        # Rounded to few digits, so that the same links on both sides count as equal.
        place = depth[joint.child], -float(f"{masses[joint.child]:.6g}"), number
        order |= {dof.name: place for dof in joint.dofs}
    return sorted(order, key=lambda name: order[name])
