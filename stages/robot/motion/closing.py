"""Finds configurations with closed loops that are within the limits and satisfy the relations.

Gauss-Newton steps on the closure of all loops, whose Jacobian is that of the twists on both paths to each
loop's frames (Siciliano et al., "Robotics", 3.1 and 3.5: the closest step to a target step by the damped
pseudo-inverse; 3.7.3), for many configurations at once.
"""

from collections.abc import Collection, Iterator, Mapping
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array, Dof, DofKind, Robot
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.loops import MAX_CLOSED_GAP
from linkwright.stages.robot.motion.pose_batch import (
    Values,
    chain_pose,
    cross,
    poses_and_frames,
    quat_products,
    quats_from_vectors,
    rotations_from_quats,
    vectors_from_rotations,
)
from linkwright.stages.robot.motion.tree_paths import TreePaths

_DAMPING = 1e-10
"""The damping, as a share of the mean square of the Jacobian's rows, by which dependent conditions do no
harm."""

_MAX_STEPS = 30
"""Largest number of steps to a closed configuration nearby."""

_CLOSED_MOVEMENT, _OPEN_MOVEMENT = 1e-13, 1e-2
"""Largest movement [rad, m] in the last step to a closed configuration, and in a late step that may still
lead to one."""


class Closer:
    """A solver that closes the loops of a robot by moving the dofs on which they depend.

    Followers move with their drivers. The dofs in `held` keep their values.
    """

    def __init__(self, robot: Robot, held: Collection[str] = ()) -> None:
        self._relations = robot.relations
        self._loops = tuple(sorted(robot.loops, key=lambda loop: loop.name))
        paths = TreePaths(robot)
        self._paths = tuple(paths.of_loop(loop) for loop in self._loops)
        ends = {end for loop in self._loops for end in (loop.link_a, loop.link_b)}
        self._top, self._joints = paths.tree_of(sorted(ends)) if ends else (robot.root.name, [])
        drivers = {relation.follower: (relation.driver, relation.multiplier) for relation in robot.relations}
        # Dof → (its driver or itself, multiplier).
        self._share = {dof.name: drivers.get(dof.name, (dof.name, 1.0)) for dof in robot.dofs}
        self._share |= {dof.name: (dof.name, 1.0) for loop in self._loops for dof in loop.dofs}
        kinds = {
            dof.name: dof.kind for dof in (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs))
        }
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
        """The dofs that the solver moves, except followers."""
        return tuple(self._kinds)

    @property
    def columns(self) -> Mapping[str, slice]:
        """The columns of `jacobian` of each dof in `names`: one for a turn or slide, three for a ball."""
        return self._columns

    @property
    def scales(self) -> Array:
        """The length (size,) [rad or m] of the range of each column's dof; a whole turn or a metre if a side
        is open."""
        return self._scales

    def jacobian(self, values: Values) -> Array:
        """Returns the derivative (n, 6 L, size) of the gaps of the L loops by the columns' values, in which
        followers move with their drivers. It maps speeds that keep the loops closed to zero."""
        return self._conditions(values)[1]

    def settled(
        self, values: Values, patience: int = _MAX_STEPS
    ) -> tuple[dict[str, Array], npt.NDArray[np.bool_]]:
        """Returns configurations near `values` whose loops are closed where that is possible, and whether
        (n,) the loops of each are. After `patience` steps those that still move far are given up."""
        current = dict(values)
        for step in range(_MAX_STEPS):
            current, moved = self._step(current, None, 1.0)
            if ((moved <= _CLOSED_MOVEMENT) | ((moved > _OPEN_MOVEMENT) & (step >= patience))).all():
                break
        gaps = self._conditions(current)[0]
        # A loop that the source leaves open by its residual counts as closed up to twice that.
        allowed = np.array([max(MAX_CLOSED_GAP, 2 * loop.residual) for loop in self._loops])
        distances = np.linalg.norm(gaps.reshape(len(gaps), -1, 2, 3), axis=3).max(axis=2)
        return current, (distances <= allowed).all(axis=1)

    def towards(self, values: Values, target: Values, steps: int) -> dict[str, Array]:
        """Returns configurations as near to the target as closed loops allow. They are reached from `values`
        in small steps, so that a mechanism does not fold the other way."""
        current = dict(values)
        for step in range(steps):
            current, _ = self._step(current, target, 1.0 / (steps - step))
        return current

    def nearest(self, values: Values, target: Values, steps: int = 200) -> dict[str, Array]:
        """Returns the configurations with closed loops that are nearest to the target, reached from `values`
        in at most `steps` steps. The distance is the sum of squares over the dofs, in units of `scales`."""
        current = dict(values)
        for _ in range(steps):
            current, moved = self._step(current, target, 1.0)
            if moved.max(initial=0.0) <= 1e-12:
                break
        return current

    def _step(self, values: Values, target: Values | None, share: float) -> tuple[dict[str, Array], Array]:
        """Returns the configurations after a step that closes the loops and goes `share` of the way to the
        target, and the largest movement (n,) [rad, m] in each. Without a target the step only closes the
        loops."""
        gaps, jacobian = self._conditions(values)
        target_step = np.zeros((len(gaps), self._size))
        if target is not None:
            for name, part in self._columns.items():
                target_step[:, part] = share * self._difference(name, values[name], target[name])
        # A ball has no limits here, so its values stay zero.
        positions = np.zeros_like(target_step)
        for name, part in self._columns.items():
            if self._kinds[name] != "ball":
                positions[:, part] = values[name][:, None]
        low, high = self._bounds.T
        step = self._closest(jacobian, gaps, target_step)
        stopped = (positions + step < low) | (positions + step > high)
        if stopped.any():
            # Dofs that would pass a limit stop there, and the others close the loops without them.
            stopped_step = np.where(stopped, np.clip(positions + step, low, high) - positions, 0.0)
            gaps = gaps + np.einsum("nij,nj->ni", jacobian, stopped_step)
            free = jacobian * ~stopped[:, None, :]
            step = np.where(
                stopped, stopped_step, self._closest(free, gaps, np.where(stopped, 0.0, target_step))
            )
            step = np.clip(positions + step, low, high) - positions
        return self._apply_step(values, step), np.abs(step).max(axis=1, initial=0.0)

    def _closest(self, jacobian: Array, gaps: Array, target_step: Array) -> Array:
        """Returns the steps (n, size) that close the gaps and are nearest to the target steps, in units of
        `scales`."""
        scales = self._scales
        steps: Array = _closest(jacobian * scales, gaps, target_step / scales) * scales
        return steps

    def _difference(self, name: str, value: Array, target: Array) -> Array:
        """Returns the step (n, 1), for a ball the rotation vector (n, 3), from a dof's values to the
        target."""
        if self._kinds[name] != "ball":
            return (target - value)[:, None]
        conjugate = value * [1, -1, -1, -1]
        return vectors_from_rotations(rotations_from_quats(quat_products(conjugate, target)))

    def _apply_step(self, values: Values, step: Array) -> dict[str, Array]:
        moved_values = dict(values)
        for name, part in self._columns.items():
            if self._kinds[name] == "ball":
                moved_values[name] = quat_products(values[name], quats_from_vectors(step[:, part]))
            else:
                moved_values[name] = values[name] + step[:, part.start]
        for relation in self._relations:
            moved_values[relation.follower] = (
                relation.multiplier * moved_values[relation.driver] + relation.offset
            )
        return moved_values

    def _conditions(self, values: Values) -> tuple[Array, Array]:
        """Returns the gaps (n, 6 L) between the frames of the L loops, and their derivative (n, 6 L, size). A
        gap is a shift [m] and a rotation vector [rad], in the axes of the link where all paths to the loops
        meet."""
        poses, frames = poses_and_frames(self._top, self._joints, values)
        ends = []
        for loop in self._loops:
            chain = chain_pose(loop.dofs, poses[loop.link_b] @ loop.b_from_frame, values)
            frames |= chain.frames
            ends.append((poses[loop.link_a] @ loop.a_from_frame, chain.end))
        parts = []
        for first, second in ends:
            turned = first[:, :3, :3] @ np.swapaxes(second[:, :3, :3], 1, 2)
            parts += [first[:, :3, 3] - second[:, :3, 3], vectors_from_rotations(turned)]
        gaps = np.concatenate(parts, axis=1)
        jacobian = np.zeros((len(gaps), 6 * len(self._loops), self._size))
        for (index, sign), dof in self._moving():
            driver, multiplier = self._share[dof.name]
            if driver not in self._columns:
                continue
            point = ends[index][0 if sign > 0 else 1][:, :3, 3]
            twist = _twists(dof, *frames[dof.name], point)
            jacobian[:, 6 * index : 6 * index + 6, self._columns[driver]] += sign * multiplier * twist
        return gaps, jacobian

    def _moving(self) -> Iterator[tuple[tuple[int, int], Dof]]:
        """Yields ((index of a loop, sign), dof) for each dof that moves a frame of a loop: the sign is 1 for
        the frame on `link_a`, and -1 for the frame on `link_b`."""
        for index, (loop, (to_a, to_b)) in enumerate(zip(self._loops, self._paths, strict=True)):
            for sign, path in ((1, to_a), (-1, to_b)):
                for joint in path:
                    yield from (((index, sign), dof) for dof in joint.dofs)
            yield from (((index, -1), dof) for dof in loop.dofs)


def _scale(kind: DofKind, low: float, high: float) -> float:
    """Returns the length of a dof's range [rad or m]; a whole turn or a metre if a side is open or the range
    is empty."""
    if 0.0 < high - low < np.inf:
        return high - low
    return 1.0 if kind == "slide" else 2.0 * np.pi


def _twists(dof: Dof, frame: Array, moved_frame: Array, point: Array) -> Array:
    """Returns the twists (n, 6, 1), for a ball (n, 6, 3), at unit speeds of a dof that moves its frame from
    `frame` to `moved_frame` (n, 4, 4). A twist is the velocity of `point` (n, 3), then the angular
    velocity."""
    if dof.kind == "slide":
        axis = frame[:, :3, :3] @ dof.axis
        return np.concatenate([axis, np.zeros_like(axis)], axis=1)[:, :, None]
    if dof.kind == "turn":
        axes = (frame[:, :3, :3] @ dof.axis)[:, :, None]
    else:
        axes = moved_frame[:, :3, :3]
    arms = (point - moved_frame[:, :3, 3])[:, :, None]
    return np.concatenate([cross(axes, arms), axes], axis=1)


def _closest(jacobian: Array, gaps: Array, target_step: Array) -> Array:
    """Returns the steps (n, size) that close `gaps` (n, m) to first order and are nearest to the target
    steps."""
    # J Jᵀ is singular if conditions depend on each other, so it is damped; the constant is for J = 0.
    square = jacobian @ np.swapaxes(jacobian, 1, 2)
    rows = square.shape[1]
    damped = _DAMPING * np.trace(square, axis1=1, axis2=2) / max(rows, 1) + 1e-30
    square = square + damped[:, None, None] * np.eye(rows)
    residuals = gaps + np.einsum("nij,nj->ni", jacobian, target_step)
    forces = np.linalg.solve(square, residuals[:, :, None])[:, :, 0]
    steps: Array = target_step - np.einsum("nij,ni->nj", jacobian, forces)
    return steps
