"""The URDF and the MJCF of one robot against each other: kinematics, masses and limits, by names."""

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

PLACES = 1e-3
"""How far [m, rad] a body may be from where the other file has it: files have few digits."""

SHARE = 5e-3
"""How far masses and limits may differ, relative to the larger."""

POSES = 5


@dataclass(frozen=True, slots=True, eq=False)
class Compiled:
    """A document and its compiled model."""

    document: ModelDocument
    model: Any

    def names(self, kind: int, number: int) -> dict[str, int]:
        """The indices of what is of this kind, by name."""
        return {name: index for index, name in enumerate(names_of(self.model, kind, number)) if name}

    @property
    def joints(self) -> dict[str, int]:
        """The hinges and slides."""
        every = self.names(mujoco.mjtObj.mjOBJ_JOINT, self.model.njnt)
        return {name: index for name, index in every.items() if self.model.jnt_type[index] >= 2}

    @property
    def bodies(self) -> dict[str, int]:
        return self.names(mujoco.mjtObj.mjOBJ_BODY, self.model.nbody)


def check_together(compiled: Sequence[Compiled]) -> Iterator[Check]:
    """One check for each URDF and the MJCF that has its name, or most of its joints where none has."""
    mjcfs = [one for one in compiled if one.document.language == "mjcf"]
    for urdf in (one for one in compiled if one.document.language == "urdf"):
        other = _partner(urdf, mjcfs)
        if other is not None:
            found = (*_limits(urdf, other), *_masses(urdf, other), *_places(urdf, other))
            name = f"{urdf.document.path.name} and {other.document.path.name}: one robot"
            both = len(urdf.joints.keys() & other.joints.keys())
            detail = (
                sentence(found) if found else f"the same masses, limits and places, of {count(both, 'joint')}"
            )
            yield Check(name, not found, detail, float(len(found)), 0.0, CODE, "warning", found)


def _partner(urdf: Compiled, mjcfs: Sequence[Compiled]) -> Compiled | None:
    own = urdf.document.path.stem
    same = [one for one in mjcfs if one.document.path.stem == own]
    if same:
        return same[0]
    joints = urdf.joints.keys()
    alike = [one for one in mjcfs if joints and one.joints.keys() == joints]
    return alike[0] if len(mjcfs) == 1 and alike else None


def _limits(urdf: Compiled, other: Compiled) -> Iterator[Finding]:
    mine, theirs = urdf.joints, other.joints
    for name in sorted(mine.keys() ^ theirs.keys()):
        where = other if name in mine else urdf
        yield Finding(named("joint", name), "name", f"{where.document.path.name} has no such joint")
    for name in sorted(mine.keys() & theirs.keys()):
        one, two = (_range(at.model, at.joints[name]) for at in (urdf, other))
        if np.abs(np.subtract(one, two)).max() > SHARE * max(1e-2, *map(abs, (*one, *two))):
            shown = (f"{at[0]:.6g} to {at[1]:.6g}" if at != (0.0, 0.0) else "no range" for at in (one, two))
            words = " in the URDF, ".join(shown)
            yield Finding(named("joint", name), "range", f"{words} in the MJCF")


def _range(model: Any, joint: int) -> tuple[float, float]:
    low, high = model.jnt_range[joint]
    return (float(low), float(high)) if model.jnt_limited[joint] else (0.0, 0.0)


def _masses(urdf: Compiled, other: Compiled) -> Iterator[Finding]:
    """Of each body with what is fixed to it, where it hangs on the same joint in both; else of all."""
    mine, theirs = _lumps(urdf), _lumps(other)
    for name in sorted(mine.keys() & theirs.keys()):
        one, two = mine[name], theirs[name]
        if abs(one - two) > SHARE * max(one, two):
            yield Finding(named("body", name), "mass", f"{one:.6g} kg in the URDF, {two:.6g} kg in the MJCF")


def _lumps(one: Compiled) -> dict[str, float]:
    """By the name of each body that moves: its mass, with what is fixed to it. Of what does not move nothing
    is known: MuJoCo leaves masses of the world out."""
    model = one.model
    masses: dict[str, float] = {}
    for name, body in one.bodies.items():
        if body and model.body_weldid[body] == body:
            masses[name] = float(model.body_mass[np.flatnonzero(model.body_weldid == body)].sum())
    return masses


def _places(urdf: Compiled, other: Compiled) -> Iterator[Finding]:
    """Bodies that are elsewhere, relative to the first that both have, at spread values of the joints."""
    joints = sorted(urdf.joints.keys() & other.joints.keys())
    bodies = sorted(urdf.bodies.keys() & other.bodies.keys() - {"world"})
    if not joints or len(bodies) < 2 or urdf.joints.keys() != other.joints.keys():
        return
    first = min(bodies, key=lambda name: urdf.bodies[name])
    random = np.random.default_rng(16)
    worst: dict[str, float] = {}
    for _ in range(POSES):
        values = {name: float(random.uniform(-0.5, 0.5)) for name in joints}
        one, two = (_at(each, values, bodies, first) for each in (urdf, other))
        for name in bodies:
            off = float(np.abs(one[name] - two[name]).max())
            worst[name] = max(worst.get(name, 0.0), off)
    # What is beyond a wrong joint is off too: the first is the one to look at.
    order = sorted(bodies, key=lambda name: urdf.bodies[name])
    for name in order:
        if worst[name] > PLACES:
            message = f"its place differs by {worst[name]:.3g} m or rad between the files"
            yield Finding(named("body", name), "pos", message)
            return


def _at(one: Compiled, values: Mapping[str, float], bodies: Sequence[str], first: str) -> dict[str, Array]:
    """The poses (3, 4) of bodies relative to the first, at values of the joints."""
    model = one.model
    data = mujoco.MjData(model)
    for name, value in values.items():
        joint = one.joints[name]
        data.qpos[model.jnt_qposadr[joint]] = value
    mujoco.mj_kinematics(model, data)
    index = one.bodies
    turn, origin = data.xmat[index[first]].reshape(3, 3).T, data.xpos[index[first]]
    return {
        name: np.column_stack(
            [turn @ data.xmat[index[name]].reshape(3, 3), turn @ (data.xpos[index[name]] - origin)]
        )
        for name in bodies
    }
