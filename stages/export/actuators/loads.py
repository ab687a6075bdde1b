"""What the driven dofs of a robot must hold and move: forces by its weight, and inertias."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.robot.couplings import Couplings, Rates
from stages.robot.dynamics import SPEEDS, mass_matrix
from stages.robot.kinematics import link_poses
from stages.robot.model import Array, Configuration, Robot
from stages.robot.pose_batch import Values, chosen, count_of, repeated
from stages.robot.pose_samples import sampled_poses
from stages.robot.start_pose import home
from stages.robot.statics import holding_forces
from stages.robot.ways import Ways

POSES = 64
"""How many poses stand for a robot's range."""

WEIGHED = 6
"""At how many of them its inertia is computed, which takes longer."""

LOW = 0.15
"""A leaf link is a foot if its centre of mass is among the lowest: in this share of the robot's height."""

REACH = 0.5
"""How far [m] slides without limits go."""


@dataclass(frozen=True, slots=True)
class Load:
    """What a driven dof has on it: `home` (with its sign: the force that holds), the largest `most`, and the
    inertias [kg m² or kg] there, `inertia` at home and `most_inertia`, which count the armatures given."""

    home: float
    most: float
    inertia: float
    most_inertia: float


def postures(robot: Robot) -> Values:
    """`home`, and then poses that stand for the robot's range, the same ones every time."""
    start = home(robot)
    if not robot.dofs:
        return repeated(start, 1)
    found = sampled_poses(robot, POSES, REACH, start)
    first = repeated(start, 1)
    return {name: np.concatenate([first[name], found[name]]) for name in first}


def loads(
    robot: Robot,
    values: Values,
    couplings: Couplings,
    driven: Sequence[str],
    compensated: Mapping[str, float],
    up: Array,
) -> dict[str, Load]:
    """By driven dof. `up` (3,) [m/s²]: against gravity, in the root link's axes. `compensated`: share of the
    weight of links that something else holds.

    On a free base half of the feet carry the whole robot: the dofs between a foot and the root also get
    that.
    """
    light = _lighter(robot, compensated)
    forces = holding_forces(light, values, up)
    rates = couplings.moved_by(driven)
    standing = {} if robot.base.fixed else _standing(light, up)
    pressed = holding_forces(light, values, up, 2.0 / max(2, len(standing))) if standing else {}
    on_feet = {name for way in standing.values() for name in way}
    inertias = _inertias(robot, values, rates)
    found = {}
    for dof in driven:
        held = _along(forces, rates[dof])
        most = float(np.abs(held).max())
        if dof in on_feet:
            most = max(most, float(np.abs(_along(pressed, rates[dof])).max()))
        found[dof] = Load(float(held[0]), most, float(inertias[dof][0]), float(inertias[dof].max()))
    return found


def _along(forces: Mapping[str, Array], rates: Rates) -> Array:
    """The force (n,) at a dof that does the work of all forces at the dofs that move with it."""
    parts = [(forces[name] * speeds).sum(axis=1) for name, speeds in rates.items() if name in forces]
    whole: Array = np.sum(parts, axis=0)
    return whole


def _lighter(robot: Robot, compensated: Mapping[str, float]) -> Robot:
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


def _standing(robot: Robot, up: Array) -> dict[str, tuple[str, ...]]:
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


def _inertias(robot: Robot, values: Values, rates: Mapping[str, Rates]) -> dict[str, Array]:
    """By driven dof: the inertia (m,) that it moves, at home and at some other poses."""
    step = max(1, (count_of(values) - 1) // (WEIGHED - 1))
    rows = np.arange(0, count_of(values), step)[:WEIGHED]
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
