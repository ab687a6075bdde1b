"""Checks that every format moves as the robot does: that engines compute the robot's own kinematics and
dynamics from each file.

Compared are poses, mass matrices and forces, at seeded random poses within limits. So the formats agree with
each other too. Not compared are armature, which is no part of the mechanism, and the speeds of balls and of
free motion, which formats count differently. In an MJCF with a loop's carrier, which has a share of a link's
mass, only the poses are compared.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.formats.urdf.names import urdf_names
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.dynamics.inertia import TINY_INERTIAL
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.system.install import install
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.dynamics.in_mujoco import mujoco_dynamics
from linkwright.stages.validate.dynamics.in_pinocchio import is_pinocchio_installed, pinocchio_dynamics
from linkwright.stages.validate.dynamics.mass_probes import inertia_roots, probe_vectors
from linkwright.stages.validate.dynamics.mujoco_features import principal_axes_error
from linkwright.stages.validate.dynamics.random_poses import poses_and_speeds
from linkwright.stages.validate.dynamics.tree_dynamics import PosedRobot, TreeDynamics, scalar_dofs
from linkwright.stages.validate.findings import largest_error, link, named, shown, worst_first
from linkwright.stages.validate.model.coordinates import BY_EQUALITY, DOFS_OF_TYPE, KINDS

TOLERANCE = 1e-9
"""Tolerance of poses [m, rad; relative to the robot's size if it is above 1 m], and relative tolerance of
matrices and forces."""

MAX_DEVIATIONS = 8.0
"""Largest sum of terms with random signs, in roots of the sum of their squares: it is exceeded in 1 of 10^13
cases."""

ELEMENTS_WITH_MASS = frozenset({"body", "geom", "inertial", "link", "joint"})
"""Elements of the user's own XML that may have a mass, or contain elements with mass."""

ABSENT_NOTE = f"Pinocchio is not installed ({install('pin')}), so that no second engine has read the URDF"

MAX_PINOCCHIO_DOFS = 100
"""Largest number of dofs for Pinocchio, whose memory grows with their cube, to 32 GB for 1,000."""

TOO_LARGE_NOTE = (
    f"Pinocchio is skipped beyond {MAX_PINOCCHIO_DOFS} dofs, since its memory grows with their cube"
)


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares a file in MuJoCo, and a URDF also in Pinocchio if that is installed."""
    robot = compiled.robot
    values, speeds = poses_and_speeds(robot)
    if not values:
        return
    posed = PosedRobot(robot, values)
    diagonals = posed.diagonal()
    vectors = probe_vectors(diagonals)
    computed, up = mujoco_dynamics(compiled.model, robot, values, speeds, vectors, compiled.urdf)
    expected = posed.dynamics(speeds, up, vectors)
    has_pinocchio = compiled.urdf and is_pinocchio_installed()
    large = sum(DOFS_OF_TYPE[KINDS[dof.kind]] for dof in robot.dofs) > MAX_PINOCCHIO_DOFS
    note = "" if has_pinocchio or not compiled.urdf else f"; {ABSENT_NOTE}"
    note = f"; {TOO_LARGE_NOTE}" if has_pinocchio and large else note
    axes_change = _axes_change(robot) if compiled.urdf else 0.0
    yield _parity_check(
        compiled, "MuJoCo", computed, expected, Inertias(diagonals, vectors, axes_change), note
    )
    if has_pinocchio and not large:
        computed = pinocchio_dynamics(compiled.path.read_bytes(), robot, values, speeds)
        upright = np.tile([0.0, 0.0, 9.81], (len(up), 1))
        expected = replace(expected, gravity=posed.gravity(upright))
        yield _parity_check(compiled, "Pinocchio", computed, expected, Inertias(diagonals, None, 0.0), "")


@dataclass(frozen=True, slots=True, eq=False)
class Inertias:
    """The scale and the tolerance of the comparison of mass matrices."""

    own: Array
    """The diagonals (n, k) of the mass matrices."""

    vectors: Array | None
    """The vectors that `probe_vectors` returns."""

    axes_change: float
    """The largest change [kg m²] of an entry of the mass matrix by the engine's own axes of inertias."""


def _parity_check(
    compiled: CompiledModel,
    engine: str,
    computed: TreeDynamics,
    expected: TreeDynamics,
    inertias: Inertias,
    note: str,
) -> Check:
    robot, urdf = compiled.robot, compiled.urdf
    pose_errors = _pose_errors(computed.poses, expected.poses)
    largest = {"poses": largest_error(pose_errors.values())}
    findings = [
        (value, Finding(link(name, urdf), "origin" if urdf else "pos", f"its pose is off by {shown(value)}"))
        for name, value in pose_errors.items()
        if not value <= TOLERANCE
    ]
    carried = not urdf and any(loop.type not in BY_EQUALITY for loop in robot.loops)
    changes = compiled.written.amendments.changes_of(compiled.path.name)
    added = [change.key for change in changes if ELEMENTS_WITH_MASS & {*" ".join(change.adds).split()}]
    names = [dof.name for dof in scalar_dofs(robot)]
    weight_scale = 9.81 * math.sqrt(sum(link.inertial.mass for link in robot.links))
    speck = inertias.axes_change + (_tiny_links_change(robot, expected) if urdf else 0.0)
    forces = (
        _force_errors(computed, expected, inertias, weight_scale, speck)
        if names and not carried and not added
        else {}
    )
    for quantity, values in forces.items():
        largest[quantity] = float(values.max())
        for name, value in zip(names, values, strict=True):
            if not value <= TOLERANCE:
                message = f"{quantity} of what it moves is off by {shown(value)}"
                findings.append((float(value), Finding(named("joint", name), "inertial", message)))
    figures = ", ".join(f"{quantity} {value:.1g}" for quantity, value in largest.items())
    left_out = f"{_omission_text(robot, carried, added)}{note}"
    detail = f"against the robot's own at {len(expected.bias)} poses: {figures}{left_out}"
    worst = largest_error(largest.values())
    return compiled.within(f"parity in {engine}", worst, TOLERANCE, detail, worst_first(findings))


def _pose_errors(computed: Mapping[str, Array], expected: Mapping[str, Array]) -> dict[str, float]:
    size = max(1.0, *(float(np.abs(pose[:, :3, 3]).max()) for pose in expected.values()))
    return {name: float(np.abs(computed[name] - pose).max()) / size for name, pose in expected.items()}


def _tiny_links_change(robot: Robot, expected: TreeDynamics) -> float:
    """Returns the inertia [kg m²] that the links which only a URDF has may add to an entry of the mass
    matrix. Links between the dofs of a joint, frames and both sides of loops have `TINY_INERTIAL` each."""
    between = sum(len(names) for names in urdf_names(robot).links_between.values())
    number = between + len(robot.frames) + 2 * len(robot.loops)
    reach = max(float(np.abs(pose[:, :3, 3]).max()) for pose in expected.poses.values())
    return number * (
        float(TINY_INERTIAL.inertia.max()) + TINY_INERTIAL.mass * (1.0 + 3.0 * (2.0 * reach) ** 2)
    )


def _axes_change(robot: Robot) -> float:
    """Returns the largest change [kg m²] of an entry of the mass matrix by the principal axes that MuJoCo
    finds for a URDF's tensors: the sum of the errors of the tensors, along any two axes."""
    sizes = [float(np.abs(link.inertial.inertia).max()) for link in robot.links]
    return sum(3.0 * size * principal_axes_error(size) for size in sizes if size)


def _force_errors(
    computed: TreeDynamics, expected: TreeDynamics, inertias: Inertias, weight_scale: float, speck: float
) -> dict[str, Array]:
    """Returns the largest relative difference of each dof, by quantity.

    The mass matrix is compared relative to the two dofs' own entries, but at least to a millionth of the
    largest. Forces are compared relative to the largest, but at least to those that the mass matrix implies:
    for the bias its entry, at a speed of 1, and for gravity the root of its entry times `weight_scale`, which
    is the root of the mass times gravity. Differences of the mass matrix up to `speck` are ignored, and so
    is their effect on gravity, at 9.81 m/s², and on the bias, at speeds of 1.
    """
    sizes, vectors = inertia_roots(inertias.own), inertias.vectors
    largest = float(sizes.max(initial=0.0))
    if vectors is None:
        scale, least = sizes[:, :, None] * sizes[:, None, :], speck
    else:
        # The vectors are already divided by the dofs' own entries, and have random signs, so that the errors
        # of entries add up like a random walk.
        scale = sizes[:, :, None] * math.sqrt(sizes.shape[1])
        least = MAX_DEVIATIONS * speck * np.linalg.norm(vectors, axis=0)
    mass_errors = np.maximum(np.abs(computed.mass - expected.mass) - least, 0.0)
    rows = {"mass matrix": (mass_errors / scale).max(axis=(0, 2))}
    for name, forces, goals, implied, ignored_error in (
        (
            "gravity",
            computed.gravity,
            expected.gravity,
            largest * weight_scale,
            9.81 * (speck - inertias.axes_change),
        ),
        ("bias", computed.bias, expected.bias, largest**2, speck * sizes.shape[1] ** 2),
    ):
        size = max(float(np.abs(goals).max(initial=0.0)), implied) or 1.0
        rows[name] = np.maximum(np.abs(forces - goals) - ignored_error, 0.0).max(axis=0) / size
    return rows


def _omission_text(robot: Robot, carried: bool, added: Sequence[str]) -> str:
    words = []
    other_count = len(robot.dofs) - len(scalar_dofs(robot))
    if other_count:
        words.append(f"the speeds of {count(other_count, 'ball or free joint', 'balls and free joints')}")
    if not robot.base.fixed:
        words.append("the base, which is held")
    if added:
        words.append(f"all forces, since {name_list(added)} may weigh")
    elif carried:
        words.append("all forces, since carriers of loops have a share of the mass")
    return f"; left out: {', '.join(words)}" if words else ""
