"""Mass, centre of mass and inertia of each link are those of its parts in CAD.

The expected values are summed independently over the parts, by second moments, not taken from the links
that the files were written from. A link whose inertial the user gave must have that.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from stages.robot.check import Check
from stages.robot.model import Array, Inertial, Link
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import body_index, placed
from stages.validate.equalities import carriers
from stages.validate.mujoco_abilities import axes_error

EXACT = 1e-9
"""Mass (relative), centre of mass [m], inertia (relative to its tensor's largest entry)."""

Lump = tuple[float, Array, Array]
"""Mass, centre of mass, inertia about it."""

UNITS = {"mass": "relative", "centre of mass": "m", "inertia": "relative to the tensor"}


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Each link's body, together with the carriers that have a share of it."""
    shares = {} if compiled.urdf else carriers(compiled.model, compiled.robot)
    worst, where = dict.fromkeys(UNITS, 0.0), dict.fromkeys(UNITS, "")
    engine_error = 0.0
    for link in compiled.robot.links:
        expected = _expected(link)
        lumps = [_lump(compiled.model, body_index(compiled.model, link.name), np.eye(4))]
        lumps += [_lump(compiled.model, body, pose) for body, pose in shares.get(link.name, [])]
        largest = float(np.abs(expected[2]).max())
        allowed = axes_error(largest) if compiled.urdf and largest else 0.0
        engine_error = max(engine_error, allowed)
        for key, value in _differences(_merged(lumps), expected, allowed).items():
            if not value < worst[key]:
                worst[key], where[key] = value, link.name
    for key, unit in UNITS.items():
        if key == "inertia" and engine_error > EXACT:
            unit += ", beyond the error of this MuJoCo's principal axes"
        detail = f"{key} of each link against CAD's parts ({unit}); worst: {where[key]}"
        yield compiled.within(key, worst[key], EXACT, detail)


def _differences(found: Lump, expected: Lump, allowed: float) -> dict[str, float]:
    """By quantity; of the inertia what is beyond the error that is `allowed`."""
    mass, com, inertia = expected
    off = float(np.abs(found[2] - inertia).max()) / (float(np.abs(inertia).max()) or 1.0)
    return {
        "mass": abs(found[0] - mass) / (mass or 1.0),
        "centre of mass": float(np.linalg.norm(found[1] - com)) if mass else 0.0,
        "inertia": max(0.0, off - allowed),
    }


def _lump(model: Any, body: int, link_from_body: Array) -> Lump:
    """The mass properties of a body, in the frame of a link."""
    axes = placed(model.body_iquat[body], model.body_ipos[body])
    tensor = axes[:3, :3] @ np.diag(model.body_inertia[body]) @ axes[:3, :3].T
    return _moved(float(model.body_mass[body]), axes[:3, 3], tensor, link_from_body)


def _expected(link: Link) -> Lump:
    """A link's mass properties, in its own frame: those that the user gave, else the sum of its parts; of a
    link that CAD does not have, its own."""
    own: Inertial | None = link.given or (None if link.parts else link.inertial)
    if own is not None:
        return own.mass, own.com, own.inertia
    parts = ((part.inertial, part.link_from_part) for part in link.parts)
    return _merged([_moved(inertial.mass, inertial.com, inertial.inertia, pose) for inertial, pose in parts])


def _moved(mass: float, com: Array, inertia: Array, a_from_b: Array) -> Lump:
    rotation = a_from_b[:3, :3]
    return mass, rotation @ com + a_from_b[:3, 3], rotation @ inertia @ rotation.T


def _merged(lumps: list[Lump]) -> Lump:
    """One body of several in the same frame.

    Sums the second-moment matrices ∫ x xᵀ dm = ½ tr(I) 1 − I + m c cᵀ, from which
    I = tr(S) 1 − S, rather than merging tensors by the parallel axis theorem.
    """
    mass = sum(lump[0] for lump in lumps)
    if mass == 0.0:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    com = sum((own * centre for own, centre, _ in lumps), np.zeros(3)) / mass
    second = np.zeros((3, 3))
    for own, centre, inertia in lumps:
        arm = centre - com
        second += 0.5 * np.trace(inertia) * np.eye(3) - inertia + own * np.outer(arm, arm)
    return mass, com, np.trace(second) * np.eye(3) - second
