"""Mass properties of links as the parts of CAD have them, and how far those of a file are from them."""

import numpy as np

from linkwright.stages.robot.model.robot import Array, Inertial, Link

EXACT = 1e-9
"""Mass (relative), centre of mass [m], inertia (relative to its tensor's largest entry)."""

Lump = tuple[float, Array, Array]
"""Mass, centre of mass, inertia about it."""

UNITS = {"mass": "relative", "centre of mass": "m", "inertia": "relative to the tensor"}


def differences(found: Lump, expected: Lump, allowed: float = 0.0) -> dict[str, float]:
    """By quantity; of the inertia what is beyond the error that is `allowed`."""
    mass, com, inertia = expected
    off = float(np.abs(found[2] - inertia).max()) / (float(np.abs(inertia).max()) or 1.0)
    return {
        "mass": abs(found[0] - mass) / (mass or 1.0),
        "centre of mass": float(np.linalg.norm(found[1] - com)) if mass else 0.0,
        "inertia": max(0.0, off - allowed),
    }


def expected_lump(link: Link, least: Inertial | None = None) -> Lump:
    """A link's mass properties, in its own frame: those that the user gave, else the sum of its parts; of a
    link that CAD does not have, its own. `least`: those of a link without mass."""
    own: Inertial | None = link.given or (None if link.parts else link.inertial)
    if least is not None and not link.inertial.mass > 0:
        own = least
    if own is not None:
        return own.mass, own.com, own.inertia
    parts = ((part.inertial, part.link_from_part) for part in link.parts)
    return merged(
        [moved_lump(inertial.mass, inertial.com, inertial.inertia, pose) for inertial, pose in parts]
    )


def moved_lump(mass: float, com: Array, inertia: Array, a_from_b: Array) -> Lump:
    rotation = a_from_b[:3, :3]
    return mass, rotation @ com + a_from_b[:3, 3], rotation @ inertia @ rotation.T


def merged(lumps: list[Lump]) -> Lump:
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
