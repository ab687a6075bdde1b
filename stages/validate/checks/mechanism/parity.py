"""Every format is the robot in motion: at seeded random poses within limits each engine finds in a file the
poses, the mass matrix and the forces that the robot's own kinematics and dynamics have.

So the formats agree with each other too. What is not compared: armature, which is no part of the mechanism;
the speeds of balls and of free motion, which formats count differently; in an MJCF all but the poses where a
loop has a carrier, which has a share of a link's mass.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.formats.urdf.names import urdf_names
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.dynamics.inertia import SPECK
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.system.install import install
from linkwright.stages.robot.text.globs import listed
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.dynamics.in_mujoco import in_mujoco
from linkwright.stages.validate.dynamics.in_pinocchio import in_pinocchio, installed
from linkwright.stages.validate.dynamics.mass_probes import own_sizes, probes
from linkwright.stages.validate.dynamics.mujoco_abilities import axes_error
from linkwright.stages.validate.dynamics.random_poses import samples
from linkwright.stages.validate.dynamics.tree_dynamics import Moving, PosedRobot, scalar_dofs
from linkwright.stages.validate.findings import link, named, shown, worst_first
from linkwright.stages.validate.model.coordinates import BY_EQUALITY, KINDS, WIDTH

ALIKE = 1e-9
"""Poses [m, rad, relative to the robot's size where that is above 1 m], matrices and forces [relative]."""

SURELY = 8.0
"""A sum of terms with signs at random is above so many times the root of their squares in 1 of 10^13."""

WEIGHS = frozenset({"body", "geom", "inertial", "link", "joint"})
"""Elements of the user's own XML that may weigh something, or have what does."""

ABSENT = f"Pinocchio is not installed ({install('pin')}), so that no second engine has read the URDF"

MOST_OF_PINOCCHIO = 100
"""Dofs: Pinocchio's memory grows with their cube, to 32 GB for 1,000."""

TOO_LARGE = f"Pinocchio is not asked of more than {MOST_OF_PINOCCHIO} dofs, whose cube its memory grows with"


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of a URDF in Pinocchio too, where that is installed."""
    robot = compiled.robot
    values, speeds = samples(robot)
    if not values:
        return
    posed = PosedRobot(robot, values)
    own = posed.diagonal()
    vectors = probes(own)
    found, up = in_mujoco(compiled.model, robot, values, speeds, vectors, compiled.urdf)
    expected = posed.moving(speeds, up, vectors)
    asks = compiled.urdf and installed()
    large = sum(WIDTH[KINDS[dof.kind]] for dof in robot.dofs) > MOST_OF_PINOCCHIO
    note = "" if asks or not compiled.urdf else f"; {ABSENT}"
    note = f"; {TOO_LARGE}" if asks and large else note
    turned = _turned(robot) if compiled.urdf else 0.0
    yield _compared(compiled, "MuJoCo", found, expected, Inertias(own, vectors, turned), note)
    if asks and not large:
        read = in_pinocchio(compiled.path.read_bytes(), robot, values, speeds)
        upright = np.tile([0.0, 0.0, 9.81], (len(up), 1))
        expected = replace(expected, gravity=posed.gravity(upright))
        yield _compared(compiled, "Pinocchio", read, expected, Inertias(own, None, 0.0), "")


@dataclass(frozen=True, slots=True, eq=False)
class Inertias:
    """`own`: the diagonals (n, k) of the mass matrices; `vectors`: as `probes` has them; `turned`: what the
    engine's own axes of inertias may change in an entry of the mass matrix [kg m²]."""

    own: Array
    vectors: Array | None
    turned: float


def _compared(
    compiled: CompiledModel, engine: str, found: Moving, expected: Moving, inertias: Inertias, note: str
) -> Check:
    robot, urdf = compiled.robot, compiled.urdf
    off = _poses_off(found.poses, expected.poses)
    most = {"poses": max(off.values())}
    findings = [
        (value, Finding(link(name, urdf), "origin" if urdf else "pos", f"its pose is off by {shown(value)}"))
        for name, value in off.items()
        if not value <= ALIKE
    ]
    carried = not urdf and any(loop.type not in BY_EQUALITY for loop in robot.loops)
    changes = compiled.written.amendments.of(compiled.path.name)
    added = [one.key for one in changes if WEIGHS & {*" ".join(one.adds).split()}]
    names = [dof.name for dof in scalar_dofs(robot)]
    weight = 9.81 * math.sqrt(sum(link.inertial.mass for link in robot.links))
    speck = inertias.turned + (_specks(robot, expected) if urdf else 0.0)
    forces = (
        _forces_off(found, expected, inertias, weight, speck) if names and not carried and not added else {}
    )
    for quantity, values in forces.items():
        most[quantity] = float(values.max())
        for name, value in zip(names, values, strict=True):
            if not value <= ALIKE:
                message = f"{quantity} of what it moves is off by {shown(value)}"
                findings.append((float(value), Finding(named("joint", name), "inertial", message)))
    figures = ", ".join(f"{quantity} {value:.1g}" for quantity, value in most.items())
    left = f"{_left_out(robot, carried, added)}{note}"
    detail = f"against the robot's own at {len(expected.bias)} poses: {figures}{left}"
    worst = max(most.values())
    return compiled.within(f"parity in {engine}", worst, ALIKE, detail, worst_first(findings))


def _poses_off(found: Mapping[str, Array], expected: Mapping[str, Array]) -> dict[str, float]:
    size = max(1.0, *(float(np.abs(pose[:, :3, 3]).max()) for pose in expected.values()))
    return {name: float(np.abs(found[name] - pose).max()) / size for name, pose in expected.items()}


def _specks(robot: Robot, expected: Moving) -> float:
    """What the links that only a URDF has may add to an entry of the mass matrix [kg m²]: those between the
    dofs of a joint, frames and both sides of loops have `SPECK` each."""
    between = sum(len(names) for names in urdf_names(robot).between.values())
    number = between + len(robot.frames) + 2 * len(robot.loops)
    reach = max(float(np.abs(pose[:, :3, 3]).max()) for pose in expected.poses.values())
    return number * (float(SPECK.inertia.max()) + SPECK.mass * (1.0 + 3.0 * (2.0 * reach) ** 2))


def _turned(robot: Robot) -> float:
    """What the axes that MuJoCo finds of a URDF's tensors may change in an entry of the mass matrix [kg m²]:
    the error of each tensor, along any two axes."""
    sizes = [float(np.abs(link.inertial.inertia).max()) for link in robot.links]
    return sum(3.0 * size * axes_error(size) for size in sizes if size)


def _forces_off(
    found: Moving, expected: Moving, inertias: Inertias, weight: float, speck: float
) -> dict[str, Array]:
    """By quantity: the largest difference of each dof. Of the mass matrix relative to the two dofs' own
    entries, but at least a millionth of the largest; of forces to the largest of them, but at least to what
    the mass matrix alone makes: its entry, by a speed of 1, and the root of its entry times `weight`, which
    is the root of the mass times gravity. Left out are `speck` of the mass matrix, and what
    it makes of the gravity, at 9.81 m/s², and of the bias, at speeds of 1."""
    own, vectors = own_sizes(inertias.own), inertias.vectors
    largest = float(own.max(initial=0.0))
    if vectors is None:
        scale, least = own[:, :, None] * own[:, None, :], speck
    else:
        # The vectors are already divided by the dofs' own entries; what entries are off by adds up in a
        # product as signs at random do.
        scale = own[:, :, None] * math.sqrt(own.shape[1])
        least = SURELY * speck * np.linalg.norm(vectors, axis=0)
    off = np.maximum(np.abs(found.mass - expected.mass) - least, 0.0)
    rows = {"mass matrix": (off / scale).max(axis=(0, 2))}
    for name, one, other, least, left in (
        ("gravity", found.gravity, expected.gravity, largest * weight, 9.81 * (speck - inertias.turned)),
        ("bias", found.bias, expected.bias, largest**2, speck * own.shape[1] ** 2),
    ):
        size = max(float(np.abs(other).max(initial=0.0)), least) or 1.0
        rows[name] = np.maximum(np.abs(one - other) - left, 0.0).max(axis=0) / size
    return rows


def _left_out(robot: Robot, carried: bool, added: Sequence[str]) -> str:
    words = []
    others = len(robot.dofs) - len(scalar_dofs(robot))
    if others:
        words.append(f"the speeds of {count(others, 'ball or free joint', 'balls and free joints')}")
    if not robot.base.fixed:
        words.append("the base, which is held")
    if added:
        words.append(f"all forces, since {listed(added)} may weigh")
    elif carried:
        words.append("all forces, since carriers of loops have a share of the mass")
    return f"; left out: {', '.join(words)}" if words else ""
