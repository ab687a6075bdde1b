"""Moves, merges and checks inertias, and computes those of solids of even density.

All tensors have true signs (off-diagonal −∫xy dm) and are about the centre of mass.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from linkwright.stages.robot.model.robot import Array, Inertial, PrimitiveKind, frozen

ZERO = Inertial(0.0, frozen(np.zeros(3)), frozen(np.zeros((3, 3))))

MIN_MOMENT = 1e-14
"""Smallest principal moment [kg m²] that we write: MuJoCo refuses 1e-15 for a body that moves, and a link
may be shared by several bodies."""

MIN_MASS = 1e-14
"""Smallest mass [kg] that we write, for the same reason."""

TINY_MASS, TINY_MOMENT = 1e-12, 1e-12
"""Mass [kg] and principal moments [kg m²] of a link that only connects two joints."""

MIN_WRITTEN_SPREAD = 1e-11
"""Smallest `spread` of a body, as a share of its largest moment, that the written digits keep."""

_OFF_DIAGONAL_TOLERANCE = 1e-14
"""Largest entry off the diagonal, as a share of the largest entry, that counts as rounding."""

_SWEEPS = 12
"""Largest number of sweeps of Jacobi's method. It squares the remainder in each: a (3, 3) tensor takes
six."""

TINY_INERTIAL = Inertial(TINY_MASS, frozen(np.zeros(3)), frozen(TINY_MOMENT * np.eye(3)))
"""The inertial of a link that only connects two joints."""


def tensor(values: Sequence[float]) -> Array:
    """Returns the symmetric (3, 3) tensor of [ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz]."""
    xx, yy, zz, xy, xz, yz = (*values, 0.0, 0.0, 0.0)[:6]
    return frozen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def moved(inertial: Inertial, a_from_b: Array) -> Inertial:
    """Returns the same body with its inertial given in frame a, from frame b: I' = R I Rᵀ, c' = R c + p.

    Holds for a reflecting transform too, as R I Rᵀ needs only an orthogonal R.
    """
    rotation = a_from_b[:3, :3]
    com = rotation @ inertial.com + a_from_b[:3, 3]
    inertia = rotation @ inertial.inertia @ rotation.T
    return Inertial(inertial.mass, frozen(com), frozen((inertia + inertia.T) / 2))


def scaled(inertial: Inertial, mass: float) -> Inertial:
    """Returns the same shape with another mass [kg]; the inertial's own mass must not be zero."""
    return Inertial(mass, inertial.com, frozen(inertial.inertia * (mass / inertial.mass)))


def merged(bodies: Sequence[Inertial]) -> Inertial:
    """Returns a rigid body from several in the same frame, by the parallel axis theorem.

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
    """Returns principal moments (3,) of a tensor (3, 3), ascending."""
    return np.asarray(np.linalg.eigvalsh(inertia), dtype=np.float64)


def principal_axes(inertia: Array) -> tuple[Array, Array]:
    """Returns principal moments (3,) and axes (3, 3; columns, right-handed): I = A diag(moments) Aᵀ.

    Jacobi's method in plain arithmetic, so that the same tensor has the same axes on every machine, also
    where moments are equal and any axes between them would do. A diagonal tensor keeps its axes.
    """
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = np.asarray(inertia, dtype=float).tolist()
    moments, axes = [xx, yy, zz], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    products = [yz, xz, xy]  # each at the index of the axis that it lacks
    negligible = _OFF_DIAGONAL_TOLERANCE * max(map(abs, (*moments, *products)))
    for _ in range(_SWEEPS):
        for p, q, r in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
            product = products[r]
            if abs(product) > negligible:
                # The smaller of the two turns that make the product zero, by its tangent.
                half = (moments[q] - moments[p]) / (2 * product)
                tangent = math.copysign(1.0, half) / (abs(half) + math.sqrt(half * half + 1))
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
    """Returns whether mass and moments are positive and fulfil the triangle inequality A + B ≥ C up to
    rounding."""
    low, middle, high = principal(inertial.inertia)
    return bool(inertial.mass > 0 and low > 0 and low + middle >= high * (1 - 1e-12))


def spread(inertia: Array) -> Array:
    """Returns the spread (3,) of a body's matter, ascending: the eigenvalues of S = ∫ x xᵀ dm = ½ tr(I) 1 −
    I, about its centre of mass. A solid with the inertia I exists exactly if none is negative, which implies
    A + B ≥ C for the moments too."""
    return np.asarray(np.linalg.eigvalsh(np.trace(inertia) / 2 * np.eye(3) - inertia), dtype=np.float64)


def with_min_spread(inertia: Array, least: float) -> Array:
    """Returns the inertia (3, 3) nearest to this one whose `spread` is nowhere below `least`."""
    values, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    second = axes @ np.diag(np.maximum(values, least)) @ axes.T
    thickened = np.trace(second) * np.eye(3) - second
    return frozen((thickened + thickened.T) / 2)


def raised_to_minimum(inertial: Inertial) -> Inertial:
    """Returns the inertial, raised to the least mass and moments that MuJoCo accepts."""
    moments = principal(inertial.inertia)
    mass = max(inertial.mass, MIN_MASS)
    if moments[0] >= MIN_MOMENT:
        return inertial if mass == inertial.mass else replace(inertial, mass=mass)
    # Each moment is the sum of two spreads; and numbers far below the largest are lost in its digits.
    floor = max(MIN_MOMENT / 2, MIN_WRITTEN_SPREAD * float(moments[2]))
    return replace(inertial, mass=mass, inertia=with_min_spread(inertial.inertia, floor))


def solid_inertia(vertices: Array, triangles: npt.NDArray[np.integer], density: float) -> Inertial:
    """Returns the solid of even `density` [kg/m³] inside a closed mesh: `vertices` (n, 3) [m], `triangles`
    (m, 3) indices into them, all facing outwards or all inwards. Raises ValueError where it encloses nothing.

    Exact, as a sum over the signed tetrahedra between the triangles and a point. A tetrahedron with its other
    corners at a, b, c from there has ∫x xᵀ dV = V/20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ), s = a + b + c, and ∫x dV =
    V/4 s (Blow and Binstock, "How to find the inertia tensor (or other mass properties) of a 3D solid body
    represented by a triangle mesh", 2004).
    """
    if not len(triangles):
        msg = "a mesh without triangles encloses nothing"
        raise ValueError(msg)
    # From a point near by: far from the origin the tetrahedra cancel badly.
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
    second = (squares + np.einsum("i,ij,il->jl", volumes, sums, sums)) / 20
    mass = density * abs(volume)
    spread = mass * (second / volume - np.outer(com, com))
    spread = (spread + spread.T) / 2
    return Inertial(mass, frozen(com + middle), frozen(np.trace(spread) * np.eye(3) - spread))


def primitive_volume(kind: PrimitiveKind, size: Sequence[float]) -> float:
    """Returns the volume [m³] of a primitive; `size` [m] as in `model.Primitive`."""
    if kind == "box":
        return math.prod(size)
    radius = size[0]
    ball = 4 / 3 * math.pi * radius**3
    if kind == "sphere":
        return ball
    barrel = math.pi * radius**2 * size[1]
    return barrel if kind == "cylinder" else barrel + ball


def primitive_area(kind: PrimitiveKind, size: Sequence[float]) -> float:
    """Returns the surface area [m²] of a primitive; `size` [m] as in `model.Primitive`."""
    if kind == "box":
        x, y, z = size
        return 2 * (x * y + y * z + z * x)
    radius = size[0]
    if kind == "sphere":
        return 4 * math.pi * radius**2
    side = 2 * math.pi * radius * size[1]
    return side + 2 * math.pi * radius**2 * (2 if kind == "capsule" else 1)


def primitive_inertial(kind: PrimitiveKind, size: Sequence[float], mass: float) -> Inertial:
    """Returns a solid primitive of even density and `mass` [kg], in the shape's own frame; `size` [m] as in
    `model.Primitive`.

    Textbook moments. A capsule is its barrel and two halves of a ball, each with its centre of mass
    3/8 of the radius beyond the barrel's end: together m (2/5 r² + 3/8 r l + l²/4) across the axis.
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
