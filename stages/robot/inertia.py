"""Moving and merging inertias.

All tensors have true signs (off-diagonal −∫xy dm) and are about the centre of mass.
"""

from collections.abc import Sequence

import numpy as np

from stages.robot.model import Array, Inertial, frozen

ZERO = Inertial(0.0, frozen(np.zeros(3)), frozen(np.zeros((3, 3))))


def moved(inertial: Inertial, a_from_b: Array) -> Inertial:
    """The same body with its inertial given in frame a, from frame b: I' = R I Rᵀ, c' = R c + p.

    Holds for a reflecting transform too, as R I Rᵀ needs only an orthogonal R.
    """
    rotation = a_from_b[:3, :3]
    com = rotation @ inertial.com + a_from_b[:3, 3]
    inertia = rotation @ inertial.inertia @ rotation.T
    return Inertial(inertial.mass, frozen(com), frozen((inertia + inertia.T) / 2))


def merged(bodies: Sequence[Inertial]) -> Inertial:
    """One rigid body from several in the same frame, by the parallel axis theorem.

    I = Σ Iᵢ + mᵢ (|dᵢ|² 1 − dᵢ dᵢᵀ), dᵢ from the common centre of mass. Bodies without mass
    leave the result unchanged.
    """
    if not bodies:
        return ZERO
    masses = np.array([body.mass for body in bodies])
    coms = np.array([body.com for body in bodies])
    tensors = np.array([body.inertia for body in bodies])
    mass = float(masses.sum())
    if mass == 0.0:
        return ZERO
    com = masses @ coms / mass
    arms = coms - com
    squares = np.einsum("i,ij,ij->", masses, arms, arms)
    inertia = tensors.sum(axis=0) + squares * np.eye(3) - np.einsum("i,ij,ik->jk", masses, arms, arms)
    return Inertial(mass, frozen(com), frozen((inertia + inertia.T) / 2))


def principal(inertia: Array) -> Array:
    """Principal moments (3,) of a tensor (3, 3), ascending."""
    return np.asarray(np.linalg.eigvalsh(inertia), dtype=np.float64)


def is_physical(inertial: Inertial) -> bool:
    """Positive mass and moments, and the triangle inequality A + B ≥ C up to rounding."""
    low, middle, high = principal(inertial.inertia)
    return bool(inertial.mass > 0 and low > 0 and low + middle >= high * (1 - 1e-12))
