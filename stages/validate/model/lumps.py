"""Sums the mass properties of links over the parts of CAD, and compares them with those of a file."""

import numpy as np

from linkwright.stages.robot.model.robot import Array, Inertial, Link

TOLERANCE = 1e-9
"""Tolerance of the mass (relative), the centre of mass [m] and the inertia (relative to the tensor's largest
entry)."""

Lump = tuple[float, Array, Array]
"""Mass [kg], centre of mass (3,) [m], and inertia (3, 3) [kg m²] about the centre of mass."""

UNITS = {"mass": "relative", "centre of mass": "m", "inertia": "relative to the tensor"}


def differences(actual: Lump, expected: Lump, allowed: float = 0.0) -> dict[str, float]:
    """Returns the differences by quantity. Of the inertia only the error beyond `allowed` counts."""
    mass, com, inertia = expected
    tensor_error = float(np.abs(actual[2] - inertia).max()) / (float(np.abs(inertia).max()) or 1.0)
    return {
        "mass": abs(actual[0] - mass) / (mass or 1.0),
        "centre of mass": float(np.linalg.norm(actual[1] - com)) if mass else 0.0,
        "inertia": max(0.0, tensor_error - allowed),
    }


def expected_lump(link: Link, least: Inertial | None = None) -> Lump:
    """Returns a link's mass properties, in its frame: those that the user gave, else the sum over its parts.
    A link that CAD does not have keeps its own. `least`: the inertial of a link without mass."""
    inertial: Inertial | None = link.given or (None if link.parts else link.inertial)
    if least is not None and not link.inertial.mass > 0:
        inertial = least
    if inertial is not None:
        return inertial.mass, inertial.com, inertial.inertia
    parts = ((part.inertial, part.link_from_part) for part in link.parts)
    return merged(
        [moved_lump(inertial.mass, inertial.com, inertial.inertia, pose) for inertial, pose in parts]
    )


def moved_lump(mass: float, com: Array, inertia: Array, a_from_b: Array) -> Lump:
    rotation = a_from_b[:3, :3]
    return mass, rotation @ com + a_from_b[:3, 3], rotation @ inertia @ rotation.T


def merged(lumps: list[Lump]) -> Lump:
    """Merges several bodies in the same frame.

    Sums the second-moment matrices ∫ x xᵀ dm = ½ tr(I) 1 − I + m c cᵀ, from which
    I = tr(S) 1 − S, rather than merging tensors by the parallel axis theorem.
    """
    mass = sum(lump[0] for lump in lumps)
    if mass == 0.0:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    com = sum((weight * centre for weight, centre, _ in lumps), np.zeros(3)) / mass
    second = np.zeros((3, 3))
    for weight, centre, inertia in lumps:
        arm = centre - com
        second += 0.5 * np.trace(inertia) * np.eye(3) - inertia + weight * np.outer(arm, arm)
    return mass, com, np.trace(second) * np.eye(3) - second
