"""Moves, merges and checks inertials, and computes those of solids of uniform density.

All tensors have true signs (off-diagonal −∫xy dm) and are about the centre of mass.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array, Inertial, PrimitiveKind, frozen

ZERO = Inertial(0.0, frozen(np.zeros(3)), frozen(np.zeros((3, 3))))
"""The inertial of a link without mass."""

MIN_MOMENT = 1e-14
"""Smallest principal moment [kg m²] in written files: MuJoCo refuses 1e-15 for a moving body, and the inertia
of a link may be divided among several bodies."""

MIN_MASS = 1e-14
"""Smallest mass [kg] in written files, for the same reason."""

TINY_MASS, TINY_MOMENT = 1e-12, 1e-12
"""Mass [kg] and principal moments [kg m²] of a link that only connects two joints."""

MIN_WRITTEN_SPREAD = 1e-11
"""Smallest `spread` of a body, as a share of its largest moment, that survives the rounding of written
numbers."""

_OFF_DIAGONAL_TOLERANCE = 1e-14
"""Largest entry off the diagonal, as a share of the largest entry, that counts as rounding."""

_SWEEPS = 12
"""Largest number of sweeps of Jacobi's method. Each sweep squares the error, so a (3, 3) tensor needs about
six."""

TINY_INERTIAL = Inertial(TINY_MASS, frozen(np.zeros(3)), frozen(TINY_MOMENT * np.eye(3)))
"""The inertial of a link that only connects two joints."""


def tensor(values: Sequence[float]) -> Array:
    """Returns the symmetric (3, 3) tensor of [ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz]."""
    xx, yy, zz, xy, xz, yz = (*values, 0.0, 0.0, 0.0)[:6]
    return frozen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def moved(inertial: Inertial, a_from_b: Array) -> Inertial:
    """Returns the inertial of a body in frame a, from that in frame b: I' = R I Rᵀ, c' = R c + p.

    This holds for a reflecting transform too, since R I Rᵀ needs only an orthogonal R.
    """
    rotation = a_from_b[:3, :3]
    com = rotation @ inertial.com + a_from_b[:3, 3]
    inertia = rotation @ inertial.inertia @ rotation.T
    return Inertial(inertial.mass, frozen(com), frozen((inertia + inertia.T) / 2))


def scaled(inertial: Inertial, mass: float) -> Inertial:
    """Returns the inertial of the same shape with another mass [kg]. The inertial's own mass must not be
    0."""
    return Inertial(mass, inertial.com, frozen(inertial.inertia * (mass / inertial.mass)))


def merged(bodies: Sequence[Inertial]) -> Inertial:
    """Returns the inertial of several bodies in the same frame as one rigid body, by the parallel axis
    theorem.

    I = Σ Iᵢ + mᵢ (|dᵢ|² 1 − dᵢ dᵢᵀ), dᵢ from the common centre of mass. Without any mass, the result is
    `ZERO`, whatever the tensors are.
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
    """Returns the principal moments (3,) of a tensor (3, 3), ascending."""
    return np.asarray(np.linalg.eigvalsh(inertia), dtype=np.float64)


def principal_axes(inertia: Array) -> tuple[Array, Array]:
    """Returns the principal moments (3,), unsorted, and the axes A (3, 3; columns, right-handed) of a tensor
    (3, 3): I = A diag(moments) Aᵀ.

    This is Jacobi's method in plain arithmetic, so that the same tensor has the same axes on every machine,
    even if two moments are equal and their axes are arbitrary. A diagonal tensor keeps its axes.
    """
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = np.asarray(inertia, dtype=float).tolist()
    moments, axes = [xx, yy, zz], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    products = [yz, xz, xy]  # each at the index of the axis that it lacks
    negligible = _OFF_DIAGONAL_TOLERANCE * max(map(abs, (*moments, *products)))
    for _ in range(_SWEEPS):
        for p, q, r in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
            product = products[r]
            if abs(product) > negligible:
                # Of the two turns that make the product zero, the smaller; `cotangent` is of twice its angle.
                cotangent = (moments[q] - moments[p]) / (2 * product)
                tangent = math.copysign(1.0, cotangent) / (
                    abs(cotangent) + math.sqrt(cotangent * cotangent + 1)
                )
                cosine = 1 / math.sqrt(tangent * tangent + 1)
                sine = tangent * cosine
                moments[p] -= tangent * product
                moments[q] += tangent * product
                rp, rq = products[q], products[p]
                products[q], products[p], products[r] = cosine * rp - sine * rq, sine * rp + cosine * rq, 0.0
                for row in axes:
                    row[p], row[q] = cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]
    return np.array(moments), np.array(axes)


def is_physical(inertial: Inertial) -> bool:
    """Returns whether mass and moments are positive, and the moments satisfy A + B ≥ C up to rounding."""
    low, middle, high = principal(inertial.inertia)
    return bool(inertial.mass > 0 and low > 0 and low + middle >= high * (1 - 1e-12))


def spread(inertia: Array) -> Array:
    """Returns the spread (3,) [kg m²] of a body's matter along its principal axes, ascending: the eigenvalues
    of the second moments S = ∫ x xᵀ dm = ½ tr(I) 1 − I about the centre of mass. A body with the inertia I
    exists if and only if no spread is negative, which implies A + B ≥ C for the moments."""
    return np.asarray(np.linalg.eigvalsh(_second_moments(inertia)), dtype=np.float64)


def _second_moments(inertia: Array) -> Array:
    """Returns ∫ x xᵀ dm (3, 3) [kg m²] of a body with this inertia (3, 3)."""
    moments: Array = np.trace(inertia) / 2 * np.eye(3) - inertia
    return moments


def with_min_spread(inertia: Array, min_spread: float) -> Array:
    """Returns the nearest inertia (3, 3) whose `spread` is at least `min_spread` along each axis."""
    spreads, axes = np.linalg.eigh(_second_moments(inertia))
    second_moments = axes @ np.diag(np.maximum(spreads, min_spread)) @ axes.T
    thickened = np.trace(second_moments) * np.eye(3) - second_moments
    return frozen((thickened + thickened.T) / 2)


def raised_to_minimum(inertial: Inertial) -> Inertial:
    """Returns the inertial, raised to `MIN_MASS` and `MIN_MOMENT` where it is below."""
    moments = principal(inertial.inertia)
    mass = max(inertial.mass, MIN_MASS)
    if moments[0] >= MIN_MOMENT:
        return inertial if mass == inertial.mass else replace(inertial, mass=mass)
    # Each moment is the sum of two spreads. A spread far below the largest moment is lost in rounding.
    min_spread = max(MIN_MOMENT / 2, MIN_WRITTEN_SPREAD * float(moments[2]))
    return replace(inertial, mass=mass, inertia=with_min_spread(inertial.inertia, min_spread))


def solid_inertia(vertices: Array, triangles: npt.NDArray[np.integer], density: float) -> Inertial:
    """Returns the inertial of the solid of uniform `density` [kg/m³] inside a closed mesh. `vertices`: (n, 3)
    [m]; `triangles`: (m, 3) indices of vertices, all facing outwards or all inwards. Raises ValueError if the
    mesh encloses no volume.

    The sum over the signed tetrahedra between the triangles and a point is exact. A tetrahedron with its
    other corners at a, b, c from there has ∫x xᵀ dV = V/20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ), s = a + b + c, and ∫x
    dV = V/4 s (Blow and Binstock, "How to find the inertia tensor (or other mass properties) of a 3D solid
    body represented by a triangle mesh", 2004).
    """
    if not len(triangles):
        msg = "a mesh without triangles encloses nothing"
        raise ValueError(msg)
    # From a point near the mesh: with a far point, large tetrahedra cancel and digits are lost.
    middle = vertices[triangles].mean(axis=(0, 1))
    corners = vertices[triangles] - middle
    a, b, c = np.moveaxis(corners, 1, 0)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    volume = float(volumes.sum())
    if abs(volume) <= 1e-12 * float(np.abs(volumes).sum()):
        msg = "the mesh encloses nothing"
        raise ValueError(msg)
    sums = corners.sum(axis=1)
    com = volumes @ sums / (4 * volume)
    squares = np.einsum("i,ikj,ikl->jl", volumes, corners, corners)
    integral = (squares + np.einsum("i,ij,il->jl", volumes, sums, sums)) / 20
    mass = density * abs(volume)
    second_moments = mass * (integral / volume - np.outer(com, com))
    second_moments = (second_moments + second_moments.T) / 2
    inertia = np.trace(second_moments) * np.eye(3) - second_moments
    return Inertial(mass, frozen(com + middle), frozen(inertia))


def primitive_volume(kind: PrimitiveKind, size: Sequence[float]) -> float:
    """Returns the volume [m³] of a primitive that is not an ellipsoid; `size` [m] as in `Primitive`."""
    if kind == "box":
        return math.prod(size)
    radius = size[0]
    ball = 4 / 3 * math.pi * radius**3
    if kind == "sphere":
        return ball
    barrel = math.pi * radius**2 * size[1]
    return barrel if kind == "cylinder" else barrel + ball


def primitive_area(kind: PrimitiveKind, size: Sequence[float]) -> float:
    """Returns the surface area [m²] of a primitive that is not an ellipsoid; `size` [m] as in `Primitive`."""
    if kind == "box":
        x, y, z = size
        return 2 * (x * y + y * z + z * x)
    radius = size[0]
    if kind == "sphere":
        return 4 * math.pi * radius**2
    side = 2 * math.pi * radius * size[1]
    return side + 2 * math.pi * radius**2 * (2 if kind == "capsule" else 1)


def primitive_inertial(kind: PrimitiveKind, size: Sequence[float], mass: float) -> Inertial:
    """Returns the inertial of a solid primitive of uniform density, in the shape's own frame. `size` [m]: as
    in `Primitive`, but not of an ellipsoid; `mass` [kg].

    A capsule is a cylinder (its barrel) and two half balls, whose centres of mass are 3/8 of the radius
    beyond the ends of the barrel: about an axis across, the two have m (2/5 r² + 3/8 r l + l²/4).
    """
    if kind == "box":
        x, y, z = size
        moments = mass / 12 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    else:
        radius, length = size[0], (0.0 if kind == "sphere" else size[1])
        barrel = mass * math.pi * radius**2 * length / primitive_volume(kind, size)
        caps = mass - barrel
        across = barrel * (3 * radius**2 + length**2) / 12
        across += caps * (2 / 5 * radius**2 + 3 / 8 * radius * length + length**2 / 4)
        along = barrel * radius**2 / 2 + caps * 2 / 5 * radius**2
        moments = np.array([across, across, along])
    return Inertial(mass, frozen(np.zeros(3)), frozen(np.diag(moments)))
