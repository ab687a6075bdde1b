"""Configurations whose loops are closed, within limits and by the relations.

Gauss-Newton steps on the closure of all loops, whose Jacobian is that of the twists on both ways to each
loop's frames (Siciliano et al., "Robotics", 3.1 and 3.5: the closest step to a wanted one by the damped
pseudo-inverse; 3.7.3), for many configurations at once.
"""

from collections.abc import Collection, Iterator, Mapping
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array, Dof, DofKind, Robot
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.loops import CLOSED
from linkwright.stages.robot.motion.pose_batch import (
    Values,
    along,
    cross,
    placed,
    product_of_quats,
    quats_of,
    rotations_of_quats,
    turns_of,
)
from linkwright.stages.robot.motion.tree_paths import Ways

_DAMPED = 1e-10
"""Of the mean square of the Jacobian's rows: what keeps conditions that follow from others from counting."""

_SETTLING = 30
"""Steps within which configurations near a closed one close."""

_SETTLED, _WILD = 1e-13, 1e-2
"""Movements [rad, m]: of the last step of one that is closed, and of later steps of one that cannot be."""


class Closer:
    """The dofs on which a robot's loops depend, and steps that close the loops with them.

    Followers are moved with their drivers. A dof that is `held` keeps its value.
    """

    def __init__(self, robot: Robot, held: Collection[str] = ()) -> None:
        self._relations = robot.relations
        self._loops = tuple(sorted(robot.loops, key=lambda loop: loop.name))
        ways = Ways(robot)
        self._ways = tuple(ways.of_loop(loop) for loop in self._loops)
        ends = {end for loop in self._loops for end in (loop.link_a, loop.link_b)}
        self._top, self._joints = ways.tree_of(sorted(ends)) if ends else (robot.root.name, [])
        drivers = {one.follower: (one.driver, one.multiplier) for one in robot.relations}
        self._share = {dof.name: drivers.get(dof.name, (dof.name, 1.0)) for dof in robot.dofs}
        self._share |= {dof.name: (dof.name, 1.0) for loop in self._loops for dof in loop.dofs}
        kinds = {dof.name: dof.kind for dof in (*robot.dofs, *(d for loop in robot.loops for d in loop.dofs))}
        names = {self._share[dof.name][0] for _, dof in self._moving()} - set(held)
        self._kinds = {name: kinds[name] for name in sorted(names) if kinds[name] != "free"}
        starts = np.cumsum([0, *(3 if kind == "ball" else 1 for kind in self._kinds.values())])
        parts = [slice(a, b) for a, b in pairwise(starts)]
        self._columns = dict(zip(self._kinds, parts, strict=True))
        self._size = int(starts[-1])
        limits = ranges(robot)
        bounds = [
            (self._kinds[name], limits.get(name, (-np.inf, np.inf)))
            for name, part in self._columns.items()
            for _ in range(part.stop - part.start)
        ]
        self._bounds = np.array([ends for _, ends in bounds]).reshape(-1, 2)
        self._scales = np.array([_scale(kind, *ends) for kind, ends in bounds])

    @property
    def names(self) -> tuple[str, ...]:
        """The dofs that are moved, but for followers."""
        return tuple(self._kinds)

    @property
    def columns(self) -> Mapping[str, slice]:
        """The columns of `jacobian` by the dofs that are moved: one, of a ball three."""
        return self._columns

    @property
    def scales(self) -> Array:
        """The range (size,) [rad or m] of each column, or a whole turn or a metre where a side is open."""
        return self._scales

    def jacobian(self, values: Values) -> Array:
        """The derivative (n, 6 L, size) of how far the loops' frames are apart: the speeds of the dofs that
        keep the loops closed are those that it maps to zero. Followers count with their drivers."""
        return self._conditions(values)[1]

    def settled(
        self, values: Values, patience: int = _SETTLING
    ) -> tuple[dict[str, Array], npt.NDArray[np.bool_]]:
        """The nearest configurations with closed loops, and which of them (n,) are closed. After `patience`
        steps those that still go far are given up."""
        now = dict(values)
        for step in range(_SETTLING):
            now, moved = self._step(now, None, 1.0)
            if ((moved <= _SETTLED) | ((moved > _WILD) & (step >= patience))).all():
                break
        off = self._conditions(now)[0]
        allowed = np.array([max(CLOSED, 2 * loop.residual) for loop in self._loops])
        apart = np.linalg.norm(off.reshape(len(off), -1, 2, 3), axis=3).max(axis=2)
        return now, (apart <= allowed).all(axis=1)

    def towards(self, values: Values, target: Values, steps: int) -> dict[str, Array]:
        """From closed configurations as near to the target as closed loops allow, in small steps: so they
        stay on the same side of where a mechanism could fold the other way."""
        now = dict(values)
        for step in range(steps):
            now, _ = self._step(now, target, 1.0 / (steps - step))
        return now

    def nearest(self, values: Values, target: Values, steps: int = 200) -> dict[str, Array]:
        """The configurations with closed loops that are nearest to the target, found from `values`: by the
        sum of squares of what each dof is off as a share of its range; where a side is open, of a whole turn
        or a metre."""
        now = dict(values)
        for _ in range(steps):
            now, moved = self._step(now, target, 1.0)
            if moved.max(initial=0.0) <= 1e-12:
                break
        return now

    def _step(self, values: Values, target: Values | None, share: float) -> tuple[dict[str, Array], Array]:
        """One step, by `share` of the way to the target, and the largest movement (n,) [rad, m] of each."""
        off, jacobian = self._conditions(values)
        wanted = np.zeros((len(off), self._size))
        if target is not None:
            for name, part in self._columns.items():
                wanted[:, part] = share * self._difference(name, values[name], target[name])
        at = np.zeros_like(wanted)
        for name, part in self._columns.items():
            if self._kinds[name] != "ball":
                at[:, part] = values[name][:, None]
        low, high = self._bounds.T
        step = self._closest(jacobian, off, wanted)
        stopped = (at + step < low) | (at + step > high)
        if stopped.any():
            held = np.where(stopped, np.clip(at + step, low, high) - at, 0.0)
            off = off + np.einsum("nij,nj->ni", jacobian, held)
            free = jacobian * ~stopped[:, None, :]
            step = np.where(stopped, held, self._closest(free, off, np.where(stopped, 0.0, wanted)))
            step = np.clip(at + step, low, high) - at
        return self._moved(values, step), np.abs(step).max(axis=1, initial=0.0)

    def _closest(self, jacobian: Array, off: Array, wanted: Array) -> Array:
        """As `_closest`, of shares of the ranges."""
        scales = self._scales
        steps: Array = _closest(jacobian * scales, off, wanted / scales) * scales
        return steps

    def _difference(self, name: str, value: Array, target: Array) -> Array:
        if self._kinds[name] != "ball":
            return (target - value)[:, None]
        back = value * [1, -1, -1, -1]
        return turns_of(rotations_of_quats(product_of_quats(back, target)))

    def _moved(self, values: Values, step: Array) -> dict[str, Array]:
        now = dict(values)
        for name, part in self._columns.items():
            if self._kinds[name] == "ball":
                now[name] = product_of_quats(values[name], quats_of(step[:, part]))
            else:
                now[name] = values[name] + step[:, part.start]
        for one in self._relations:
            now[one.follower] = one.multiplier * now[one.driver] + one.offset
        return now

    def _conditions(self, values: Values) -> tuple[Array, Array]:
        """How far the loops' frames are apart (n, 6 L), shift [m] and turn [rad] in the axes of the
        link where all ways to them meet, and its derivative (n, 6 L, size)."""
        poses, frames = placed(self._top, self._joints, values)
        ends = []
        for loop in self._loops:
            second = along(loop.dofs, poses[loop.link_b] @ loop.b_from_frame, values, frames)
            ends.append((poses[loop.link_a] @ loop.a_from_frame, second))
        parts = []
        for first, second in ends:
            turned = first[:, :3, :3] @ np.swapaxes(second[:, :3, :3], 1, 2)
            parts += [first[:, :3, 3] - second[:, :3, 3], turns_of(turned)]
        off = np.concatenate(parts, axis=1)
        jacobian = np.zeros((len(off), 6 * len(self._loops), self._size))
        for (index, sign), dof in self._moving():
            driver, multiplier = self._share[dof.name]
            if driver not in self._columns:
                continue
            point = ends[index][0 if sign > 0 else 1][:, :3, 3]
            twist = _twists(dof, *frames[dof.name], point)
            jacobian[:, 6 * index : 6 * index + 6, self._columns[driver]] += sign * multiplier * twist
        return off, jacobian

    def _moving(self) -> Iterator[tuple[tuple[int, int], Dof]]:
        """The index of a loop, the sign of its frame, and a dof by which that frame moves."""
        for index, (loop, (to_a, to_b)) in enumerate(zip(self._loops, self._ways, strict=True)):
            for sign, way in ((1, to_a), (-1, to_b)):
                for joint in way:
                    yield from (((index, sign), dof) for dof in joint.dofs)
            yield from (((index, -1), dof) for dof in loop.dofs)


def _scale(kind: DofKind, low: float, high: float) -> float:
    """A dof's range [rad or m], or what stands for it where a side is open."""
    if 0.0 < high - low < np.inf:
        return high - low
    return 1.0 if kind == "slide" else 2.0 * np.pi


def _twists(dof: Dof, before: Array, after: Array, point: Array) -> Array:
    """(n, 6, 1), of a ball (n, 6, 3): the velocity of `point` (n, 3) and the angular velocity, in the axes
    of these poses, for unit speeds of a dof."""
    if dof.kind == "slide":
        axis = before[:, :3, :3] @ dof.axis
        return np.concatenate([axis, np.zeros_like(axis)], axis=1)[:, :, None]
    if dof.kind == "turn":
        axes = (before[:, :3, :3] @ dof.axis)[:, :, None]
    else:
        axes = after[:, :3, :3]
    arms = (point - after[:, :3, 3])[:, :, None]
    return np.concatenate([cross(axes, arms), axes], axis=1)


def _closest(jacobian: Array, off: Array, wanted: Array) -> Array:
    """The steps (n, size) nearest to the wanted ones that take `off` (n, m) away, to first order."""
    square = jacobian @ np.swapaxes(jacobian, 1, 2)
    rows = square.shape[1]
    damped = _DAMPED * np.trace(square, axis1=1, axis2=2) / max(rows, 1) + 1e-30
    square = square + damped[:, None, None] * np.eye(rows)
    left = off + np.einsum("nij,nj->ni", jacobian, wanted)
    forces = np.linalg.solve(square, left[:, :, None])[:, :, 0]
    steps: Array = wanted - np.einsum("nij,ni->nj", jacobian, forces)
    return steps
