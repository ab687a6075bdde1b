"""Computes the loads of driven dofs: the forces that hold the weight, and the inertias that they move."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.dynamics.mass_matrix import SPEEDS, held_inertias, mass_matrix
from linkwright.stages.robot.dynamics.statics import holding_forces
from linkwright.stages.robot.model.robot import Array, Configuration, DofKind, Robot
from linkwright.stages.robot.motion.couplings import Couplings, Rates
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.pose_batch import Values, count_of, many_link_poses, repeated, select
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.motion.tree_paths import TreePaths

POSES = 64
"""Number of poses that sample a robot's range."""

INERTIA_POSES = 6
"""Number of these poses at which inertias are computed, which takes longer."""

FOOT_HEIGHT_SHARE = 0.15
"""Share of the robot's height, from below, in which the centre of mass of a foot lies. Feet are leaf
links."""

SLIDE_RANGE = 0.5
"""Range [m] of sampled values for slides without limits."""

MAX_LEVERAGE = 10.0
"""Largest leverage of a loop that counts in a load."""


@dataclass(frozen=True, slots=True)
class Load:
    """The load of a driven dof over the robot's range."""

    largest_force: float
    """The largest force [N m or N] that holds the weight."""

    inertia: float
    """The inertia [kg m² or kg] that the dof moves at home, with the armatures that are set."""

    largest_inertia: float
    """The largest inertia [kg m² or kg] that the dof moves, with the armatures that are set."""

    standing: float = 0.0
    """The inertia [kg m² or kg] of the robot about a dof between a foot and the root while the foot stands; 0
    for other dofs."""

    left_out: tuple[float, ...] = ()
    """The values of the dof at the poses that are left out, because a loop is near a singular pose there."""

    @property
    def carried(self) -> float:
        """The largest inertia [kg m² or kg] that the dof moves, in the air or while a foot stands."""
        return max(self.largest_inertia, self.standing)


@dataclass(frozen=True, slots=True)
class LoadBounds:
    """Bounds of the force and the inertia of a dof of a loop, whose leverage is unlimited near a singular
    pose. A slide carries at most `MAX_LEVERAGE` times the weight of all that moves, and moves at most its
    mass. A turn carries at most that force times the reach, and moves at most that mass times the square of
    the reach."""

    weight: float
    """The weight [N] of all links that move, without what gravity compensation holds."""

    mass: float
    """The mass [kg] of all links that move."""

    reach: float
    """The diagonal [m] of the box around the centres of mass in all poses."""

    def force(self, kind: DofKind) -> float:
        """Returns the largest force [N m or N] of a dof of this kind."""
        return MAX_LEVERAGE * self.weight * (1.0 if kind == "slide" else self.reach)

    def inertia(self, kind: DofKind) -> float:
        """Returns the largest inertia [kg m² or kg] that a dof of this kind moves."""
        return self.mass * (1.0 if kind == "slide" else self.reach**2)


def postures(robot: Robot) -> Values:
    """Returns `home`, followed by sampled poses of the robot's range. The samples are always the same."""
    start = home(robot)
    if not robot.dofs:
        return repeated(start, 1)
    samples = sampled_poses(robot, POSES, SLIDE_RANGE, start)
    first = repeated(start, 1)
    return {name: np.concatenate([first[name], samples[name]]) for name in first}


def bounds_of(robot: Robot, values: Values, up: Array, compensated: Mapping[str, float]) -> LoadBounds:
    """Returns the bounds of loads at dofs of loops. `up` (3,) [m/s²]: opposite to gravity; `compensated`:
    link → the share of its weight that gravity compensation holds."""
    poses = many_link_poses(robot, values)
    centers = [(poses[link.name] @ np.append(link.inertial.com, 1.0))[:, :3] for link in robot.links]
    all_centers = np.concatenate(centers)
    fixed_links = _rigid_with_root(robot) if robot.base.fixed else set()
    moving_links = [link for link in robot.links if link.name not in fixed_links]
    mass = sum(link.inertial.mass for link in moving_links)
    held_mass = sum(link.inertial.mass * compensated.get(link.name, 0.0) for link in moving_links)
    reach = float(np.linalg.norm(all_centers.max(axis=0) - all_centers.min(axis=0)))
    return LoadBounds((mass - held_mass) * float(np.linalg.norm(up)), mass, reach)


def _rigid_with_root(robot: Robot) -> set[str]:
    rigid = {robot.root.name}
    for joint in robot.joints:
        if joint.parent in rigid and not joint.dofs:
            rigid.add(joint.child)
    return rigid


def loads(
    robot: Robot,
    values: Values,
    couplings: Couplings,
    driven: Sequence[str],
    up: Array,
    bounds: LoadBounds,
    lightened: Robot,
) -> dict[str, Load]:
    """Returns the load of each driven dof over the poses `values`, the first of which is `home`. `up` (3,)
    [m/s²]: opposite to gravity, in the root link's axes; `bounds`: the limits for dofs of loops;
    `lightened`: the robot without the weight that gravity compensation holds, which reduces the forces and
    not the inertias.

    With a free base, half of the feet carry the whole robot. The loads of the dofs between a foot and the
    root include this case.
    """
    forces = holding_forces(lightened, values, up)
    rates = couplings.moved_by(driven)
    singular = couplings.near_singular(driven)
    # Without gravity nothing stands.
    feet = {} if robot.base.fixed or not np.any(up) else _feet(robot, up)
    share = 2.0 / max(2, len(feet))
    forces_on_feet = holding_forces(lightened, values, up, share) if feet else {}
    dofs_above_feet = {name for names in feet.values() for name in names}
    inertias_on_feet = held_inertias(robot, home(robot)) if feet else {}
    rows = _inertia_rows(values)
    inertias = _inertias(robot, values, rates, rows)
    kinds = {dof.name: dof.kind for dof in robot.dofs}
    loads_of = {}
    for dof in driven:
        force_sizes, moved_inertia, standing = np.abs(combined_force(forces, rates[dof])), inertias[dof], 0.0
        if dof in dofs_above_feet:
            force_sizes = np.maximum(force_sizes, np.abs(combined_force(forces_on_feet, rates[dof])))
            standing = share * float(inertias_on_feet[dof].max())
        excluded = np.zeros(count_of(values), dtype=bool)
        if dof in singular:
            excluded = singular[dof] if not singular[dof].all() else excluded
            force_sizes = np.minimum(force_sizes, bounds.force(kinds[dof]))
            moved_inertia = np.minimum(moved_inertia, bounds.inertia(kinds[dof]))
        largest_inertia = float(moved_inertia[~excluded[rows]].max(initial=0.0)) or float(moved_inertia[0])
        left_out = tuple(values[dof][excluded].tolist())
        loads_of[dof] = Load(
            float(force_sizes[~excluded].max()), float(moved_inertia[0]), largest_inertia, standing, left_out
        )
    return loads_of


def combined_force(forces: Mapping[str, Array], rates: Rates) -> Array:
    """Returns the force (n,) at a dof that does the same work as the forces at all dofs that move with it.
    `forces`: dof → its force (n, k); `rates`: dof → its speeds (n, k) for a unit speed of the dof."""
    parts = [(forces[name] * speeds).sum(axis=1) for name, speeds in rates.items() if name in forces]
    total: Array = np.sum(parts, axis=0)
    return total


def without_compensated_weight(robot: Robot, compensated: Mapping[str, float]) -> Robot:
    """Returns the robot with the masses that remain for its actuators to hold: it has the loads of the robot,
    but not its inertias. `compensated`: link → the share of its weight that gravity compensation holds."""
    if not compensated:
        return robot
    links = tuple(
        replace(
            link,
            inertial=replace(
                link.inertial, mass=link.inertial.mass * (1.0 - compensated.get(link.name, 0.0))
            ),
        )
        for link in robot.links
    )
    return replace(robot, links=links)


def _feet(robot: Robot, up: Array) -> dict[str, tuple[str, ...]]:
    """Returns, by foot, the dofs between it and the root. The feet are the lowest leaves of the tree at
    `home`."""
    poses = link_poses(robot, home(robot))
    heights = {
        link.name: float((poses[link.name] @ np.append(link.inertial.com, 1.0))[:3] @ up)
        for link in robot.links
        if link.inertial.mass > 0
    }
    paths = TreePaths(robot)
    parents = {joint.parent for joint in robot.joints}
    lowest = min(heights.values(), default=0.0)
    limit = lowest + FOOT_HEIGHT_SHARE * (max(heights.values(), default=0.0) - lowest)
    dofs_above: dict[str, tuple[str, ...]] = {}
    for name, height in heights.items():
        if name in parents or name == robot.root.name or height > limit:
            continue
        dofs_above[name] = tuple(dof.name for joint in paths.up(name) for dof in joint.dofs)
    return dofs_above


def _inertia_rows(values: Values) -> npt.NDArray[np.intp]:
    """Returns the indices (m,) of the poses at which inertias are computed, `home` first."""
    step = max(1, (count_of(values) - 1) // (INERTIA_POSES - 1))
    return np.arange(0, count_of(values), step)[:INERTIA_POSES]


def _inertias(
    robot: Robot, values: Values, rates: Mapping[str, Rates], rows: npt.NDArray[np.intp]
) -> dict[str, Array]:
    """Returns, by driven dof, the inertia (m,) that it moves at the poses with the indices `rows` (m,)."""
    poses = select(values, rows)
    armature = np.concatenate(
        [np.full(SPEEDS[dof.kind], dof.dynamics.armature or 0.0) for dof in robot.dofs] or [np.zeros(0)]
    )
    ends = np.cumsum([0, *(SPEEDS[dof.kind] for dof in robot.dofs)])
    columns = {
        dof.name: slice(start, end) for dof, start, end in zip(robot.dofs, ends, ends[1:], strict=False)
    }
    inertias: dict[str, list[float]] = {dof: [] for dof in rates}
    for index, row in enumerate(rows):
        matrix = mass_matrix(robot, _configuration_at(poses, index)) + np.diag(armature)
        for dof, moving in rates.items():
            moving_dofs = [name for name in moving if name in columns]
            indices = np.concatenate(
                [np.arange(columns[name].start, columns[name].stop) for name in moving_dofs]
            )
            speeds = np.concatenate([moving[name][row] for name in moving_dofs])
            inertias[dof].append(float(speeds @ matrix[np.ix_(indices, indices)] @ speeds))
    return {dof: np.array(values_of_dof) for dof, values_of_dof in inertias.items()}


def _configuration_at(values: Values, index: int) -> Configuration:
    return {
        name: tuple(value[index].tolist()) if value.ndim > 1 else float(value[index])
        for name, value in values.items()
    }
