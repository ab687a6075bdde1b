"""What the driven dofs of a robot must hold and move: forces by its weight, and inertias."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.dynamics.mass_matrix import SPEEDS, held_inertias, mass_matrix
from linkwright.stages.robot.dynamics.statics import holding_forces
from linkwright.stages.robot.model.robot import Array, Configuration, DofKind, Robot
from linkwright.stages.robot.motion.couplings import Couplings, Rates
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.pose_batch import Values, chosen, count_of, many_link_poses, repeated
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.motion.tree_paths import Ways

POSES = 64
"""How many poses stand for a robot's range."""

WEIGHED = 6
"""At how many of them its inertia is computed, which takes longer."""

LOW = 0.15
"""A leaf link is a foot if its centre of mass is among the lowest: in this share of the robot's height."""

REACH = 0.5
"""How far [m] slides without limits go."""

LEVERAGE = 10.0
"""The largest leverage of a loop that counts in a load."""


@dataclass(frozen=True, slots=True)
class Load:
    """What a driven dof has on it over the robot's range: the largest force `most` that holds the weight, and
    the inertias [kg m² or kg] that it moves, `inertia` at home and `most_inertia`, which count the armatures
    that are given. `standing`: of a dof between a foot and the root, the inertia of the robot that turns
    about it where the foot stands, else 0. `left_out`: the values of the dof at the poses that did not count,
    since they are near a singular pose of a loop."""

    most: float
    inertia: float
    most_inertia: float
    standing: float = 0.0
    left_out: tuple[float, ...] = ()

    @property
    def carried(self) -> float:
        """The largest inertia that the dof moves, in the air or where a foot stands."""
        return max(self.most_inertia, self.standing)


@dataclass(frozen=True, slots=True)
class LoadBounds:
    """The largest force and inertia of a dof of a loop that count, since its leverage has no end near a
    singular pose: a slide carries at most `LEVERAGE` times the weight of all that moves, and moves at most
    its mass; a turn carries that times the reach, and moves that times its square."""

    weight: float
    mass: float
    reach: float

    def force(self, kind: DofKind) -> float:
        return LEVERAGE * self.weight * (1.0 if kind == "slide" else self.reach)

    def inertia(self, kind: DofKind) -> float:
        return self.mass * (1.0 if kind == "slide" else self.reach**2)


def postures(robot: Robot) -> Values:
    """`home`, and then poses that stand for the robot's range, the same ones every time."""
    start = home(robot)
    if not robot.dofs:
        return repeated(start, 1)
    found = sampled_poses(robot, POSES, REACH, start)
    first = repeated(start, 1)
    return {name: np.concatenate([first[name], found[name]]) for name in first}


def bounds_of(robot: Robot, values: Values, up: Array) -> LoadBounds:
    """`up` (3,) [m/s²]: against gravity. The reach is the diagonal of the box around the centres of mass of
    all links in all poses."""
    poses = many_link_poses(robot, values)
    centers = [(poses[link.name] @ np.append(link.inertial.com, 1.0))[:, :3] for link in robot.links]
    every = np.concatenate(centers)
    held = _rigid_with_root(robot) if robot.base.fixed else set()
    mass = sum(link.inertial.mass for link in robot.links if link.name not in held)
    reach = float(np.linalg.norm(every.max(axis=0) - every.min(axis=0)))
    return LoadBounds(mass * float(np.linalg.norm(up)), mass, reach)


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
) -> dict[str, Load]:
    """By driven dof, over the poses `values`, of which the first is `home`. `up` (3,) [m/s²]: against
    gravity, in the root link's axes; `bounds`: of the dofs of loops.

    On a free base half of the feet carry the whole robot: the dofs between a foot and the root also get
    that.
    """
    forces = holding_forces(robot, values, up)
    rates = couplings.moved_by(driven)
    singular = couplings.near_singular(driven)
    feet = {} if robot.base.fixed else _feet(robot, up)
    share = 2.0 / max(2, len(feet))
    pressed = holding_forces(robot, values, up, share) if feet else {}
    on_feet = {name for way in feet.values() for name in way}
    held = held_inertias(robot, home(robot)) if feet else {}
    rows = _weighed(values)
    inertias = _inertias(robot, values, rates, rows)
    kinds = {dof.name: dof.kind for dof in robot.dofs}
    loads_of = {}
    for dof in driven:
        sizes, moved, standing = np.abs(along(forces, rates[dof])), inertias[dof], 0.0
        if dof in on_feet:
            sizes = np.maximum(sizes, np.abs(along(pressed, rates[dof])))
            standing = share * float(held[dof].max())
        out = np.zeros(count_of(values), dtype=bool)
        if dof in singular:
            out = singular[dof] if not singular[dof].all() else out
            sizes = np.minimum(sizes, bounds.force(kinds[dof]))
            moved = np.minimum(moved, bounds.inertia(kinds[dof]))
        most_moved = float(moved[~out[rows]].max(initial=0.0)) or float(moved[0])
        left_out = tuple(values[dof][out].tolist())
        loads_of[dof] = Load(float(sizes[~out].max()), float(moved[0]), most_moved, standing, left_out)
    return loads_of


def along(forces: Mapping[str, Array], rates: Rates) -> Array:
    """The force (n,) at a dof that does the work of all forces at the dofs that move with it."""
    parts = [(forces[name] * speeds).sum(axis=1) for name, speeds in rates.items() if name in forces]
    whole: Array = np.sum(parts, axis=0)
    return whole


def lighter(robot: Robot, compensated: Mapping[str, float]) -> Robot:
    """The robot without the weight that something else holds. `compensated`: its share, by link."""
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
    """By foot, a lowest leaf of the tree at `home`: the dofs between it and the root."""
    poses = link_poses(robot, home(robot))
    heights = {
        link.name: float((poses[link.name] @ np.append(link.inertial.com, 1.0))[:3] @ up)
        for link in robot.links
        if link.inertial.mass > 0
    }
    ways = Ways(robot)
    parents = {joint.parent for joint in robot.joints}
    lowest = min(heights.values(), default=0.0)
    limit = lowest + LOW * (max(heights.values(), default=0.0) - lowest)
    found: dict[str, tuple[str, ...]] = {}
    for name, height in heights.items():
        if name in parents or name == robot.root.name or height > limit:
            continue
        found[name] = tuple(dof.name for joint in ways.up(name) for dof in joint.dofs)
    return found


def _weighed(values: Values) -> npt.NDArray[np.intp]:
    """The poses (m,) at which inertias are computed, `home` first."""
    step = max(1, (count_of(values) - 1) // (WEIGHED - 1))
    return np.arange(0, count_of(values), step)[:WEIGHED]


def _inertias(
    robot: Robot, values: Values, rates: Mapping[str, Rates], rows: npt.NDArray[np.intp]
) -> dict[str, Array]:
    """By driven dof: the inertia (m,) that it moves at these poses (m,)."""
    some = chosen(values, rows)
    armature = np.concatenate(
        [np.full(SPEEDS[dof.kind], dof.dynamics.armature or 0.0) for dof in robot.dofs] or [np.zeros(0)]
    )
    ends = np.cumsum([0, *(SPEEDS[dof.kind] for dof in robot.dofs)])
    columns = {dof.name: slice(a, b) for dof, a, b in zip(robot.dofs, ends, ends[1:], strict=False)}
    found: dict[str, list[float]] = {dof: [] for dof in rates}
    for index, row in enumerate(rows):
        matrix = mass_matrix(robot, _one(some, index)) + np.diag(armature)
        for dof, moving in rates.items():
            there = [name for name in moving if name in columns]
            at = np.concatenate([np.arange(columns[name].start, columns[name].stop) for name in there])
            speeds = np.concatenate([moving[name][row] for name in there])
            found[dof].append(float(speeds @ matrix[np.ix_(at, at)] @ speeds))
    return {dof: np.array(each) for dof, each in found.items()}


def _one(values: Values, index: int) -> Configuration:
    return {
        name: tuple(value[index].tolist()) if value.ndim > 1 else float(value[index])
        for name, value in values.items()
    }
