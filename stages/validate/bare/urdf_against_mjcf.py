"""Compares the URDF and the MJCF of the same robot: kinematics, masses and limits, by names."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import names_of
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.reading.documents import ModelDocument, sentence

CODE = "C-TOGETHER"

POSE_TOLERANCE = 1e-3
"""Tolerance [m, rad] for the poses of bodies: the files may be written with few digits."""

RELATIVE_TOLERANCE = 5e-3
"""Tolerance for masses and limits, relative to the larger of the two values."""

MIN_LIMIT = 1e-2
"""Smallest value [rad, m] to which differences of limits are relative: limits may be zero."""

POSES = 5
"""Number of poses at which the bodies are compared."""


@dataclass(frozen=True, slots=True, eq=False)
class CompiledDocument:
    """A document and its compiled model."""

    document: ModelDocument
    model: Any

    def names(self, kind: int, number: int) -> dict[str, int]:
        """Returns the indices of the named elements of this kind, by name."""
        return {name: index for index, name in enumerate(names_of(self.model, kind, number)) if name}

    @property
    def joints(self) -> dict[str, int]:
        """The hinges and slides."""
        indices = self.names(mujoco.mjtObj.mjOBJ_JOINT, self.model.njnt)
        scalar = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
        types = self.model.jnt_type
        return {name: index for name, index in indices.items() if int(types[index]) in scalar}

    @property
    def bodies(self) -> dict[str, int]:
        return self.names(mujoco.mjtObj.mjOBJ_BODY, self.model.nbody)


def check_together(compiled: Sequence[CompiledDocument]) -> Iterator[Check]:
    """Compares each URDF with the MJCF of the same name, else with the only MJCF if its joints match."""
    mjcfs = [file for file in compiled if file.document.language == "mjcf"]
    for urdf in (file for file in compiled if file.document.language == "urdf"):
        mjcf = _partner(urdf, mjcfs)
        if mjcf is not None:
            findings = (
                *_limit_findings(urdf, mjcf),
                *_mass_findings(urdf, mjcf),
                *_pose_findings(urdf, mjcf),
            )
            name = f"{urdf.document.path.name} and {mjcf.document.path.name}: one robot"
            common_joints = len(urdf.joints.keys() & mjcf.joints.keys())
            detail = (
                sentence(findings)
                if findings
                else f"the same masses, limits and places, of {count(common_joints, 'joint')}"
            )
            yield Check(name, not findings, detail, float(len(findings)), 0.0, CODE, "warning", findings)


def _partner(urdf: CompiledDocument, mjcfs: Sequence[CompiledDocument]) -> CompiledDocument | None:
    """Returns the MJCF of the same name, else the only MJCF if it has the same joints; None without such an
    MJCF."""
    name = urdf.document.path.stem
    namesakes = [mjcf for mjcf in mjcfs if mjcf.document.path.stem == name]
    if namesakes:
        return namesakes[0]
    joints = urdf.joints.keys()
    matches = [mjcf for mjcf in mjcfs if joints and mjcf.joints.keys() == joints]
    return matches[0] if len(mjcfs) == 1 and matches else None


def _limit_findings(urdf: CompiledDocument, mjcf: CompiledDocument) -> Iterator[Finding]:
    """Reports joints that only one of the files has, and joints whose ranges differ."""
    urdf_items, mjcf_items = urdf.joints, mjcf.joints
    for name in sorted(urdf_items.keys() ^ mjcf_items.keys()):
        other_file = mjcf if name in urdf_items else urdf
        yield Finding(named("joint", name), "name", f"{other_file.document.path.name} has no such joint")
    for name in sorted(urdf_items.keys() & mjcf_items.keys()):
        first, second = (_range(file.model, file.joints[name]) for file in (urdf, mjcf))
        size = max(MIN_LIMIT, *map(abs, (*first, *second)))
        if np.abs(np.subtract(first, second)).max() > RELATIVE_TOLERANCE * size:
            shown = (
                f"{ends[0]:.6g} to {ends[1]:.6g}" if ends != (0.0, 0.0) else "no range"
                for ends in (first, second)
            )
            ranges = " in the URDF, ".join(shown)
            yield Finding(named("joint", name), "range", f"{ranges} in the MJCF")


def _range(model: Any, joint: int) -> tuple[float, float]:
    """Returns the range [rad, m] of a joint; (0, 0) without limits."""
    low, high = model.jnt_range[joint]
    return (float(low), float(high)) if model.jnt_limited[joint] else (0.0, 0.0)


def _mass_findings(urdf: CompiledDocument, mjcf: CompiledDocument) -> Iterator[Finding]:
    """Compares the masses of moving bodies, each with the mass of the bodies that are fixed to it."""
    urdf_items, mjcf_items = _moving_masses(urdf), _moving_masses(mjcf)
    for name in sorted(urdf_items.keys() & mjcf_items.keys()):
        first, second = urdf_items[name], mjcf_items[name]
        if abs(first - second) > RELATIVE_TOLERANCE * max(first, second):
            yield Finding(
                named("body", name), "mass", f"{first:.6g} kg in the URDF, {second:.6g} kg in the MJCF"
            )


def _moving_masses(file: CompiledDocument) -> dict[str, float]:
    """Maps each moving body to its mass, including that of the bodies fixed to it. Bodies that are fixed to
    the world are left out, since MuJoCo drops the masses of the world."""
    model = file.model
    masses: dict[str, float] = {}
    for name, body in file.bodies.items():
        if body and model.body_weldid[body] == body:
            masses[name] = float(model.body_mass[np.flatnonzero(model.body_weldid == body)].sum())
    return masses


def _pose_findings(urdf: CompiledDocument, mjcf: CompiledDocument) -> Iterator[Finding]:
    """Reports the first body whose pose differs, relative to the first common body, at random poses."""
    joints = sorted(urdf.joints.keys() & mjcf.joints.keys())
    bodies = sorted(urdf.bodies.keys() & mjcf.bodies.keys() - {"world"})
    if not joints or len(bodies) < 2 or urdf.joints.keys() != mjcf.joints.keys():
        return
    first = min(bodies, key=lambda name: urdf.bodies[name])
    # Any fixed seed: the result must not vary.
    random = np.random.default_rng(16)
    largest_difference: dict[str, float] = {}
    for _ in range(POSES):
        values = {name: float(random.uniform(-0.5, 0.5)) for name in joints}
        of_urdf, of_mjcf = (_poses_at(file, values, bodies, first) for file in (urdf, mjcf))
        for name in bodies:
            difference = float(np.abs(of_urdf[name] - of_mjcf[name]).max())
            largest_difference[name] = max(largest_difference.get(name, 0.0), difference)
    # All bodies behind a wrong joint differ, so only the first is reported.
    order = sorted(bodies, key=lambda name: urdf.bodies[name])
    for name in order:
        if largest_difference[name] > POSE_TOLERANCE:
            message = f"its pose differs by {largest_difference[name]:.3g} m or rad between the files"
            yield Finding(named("body", name), "pos", message)
            return


def _poses_at(
    file: CompiledDocument, values: Mapping[str, float], bodies: Sequence[str], first: str
) -> dict[str, Array]:
    """Returns the poses (3, 4) of bodies relative to the body `first`, at given joint values."""
    model = file.model
    data = mujoco.MjData(model)
    for name, value in values.items():
        joint = file.joints[name]
        data.qpos[model.jnt_qposadr[joint]] = value
    mujoco.mj_kinematics(model, data)
    index = file.bodies
    first_from_world, origin = data.xmat[index[first]].reshape(3, 3).T, data.xpos[index[first]]
    return {
        name: np.column_stack(
            [
                first_from_world @ data.xmat[index[name]].reshape(3, 3),
                first_from_world @ (data.xpos[index[name]] - origin),
            ]
        )
        for name in bodies
    }
