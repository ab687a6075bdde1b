"""Computes random mass properties near those of a body, such as a solid can have.

The mass of a body is spread about its centre with the covariance Σ/m = A Aᵀ, A lower triangular (Cholesky).
Every mass at c + A y is moved to c + A (t + T y), with T lower triangular, and weighed by f: a congruence of
the pseudo-inertia, which keeps it positive (Rucker and Wensing, "Smooth parameterization of rigid-body
inertia", 2022). So t is counted in the body's own radius, and T stretches and shears it by shares.

Only sums, products, quotients and square roots of single numbers are used, which IEEE 754 defines to the last
bit: the results are the same everywhere, unlike those of LAPACK.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.export.variants.draws import Column

Rows = Sequence[Sequence[Column | float]]

JACOBI_SWEEPS = 8
"""Number of sweeps of Jacobi's rotations: they converge quadratically, and 5 suffice for any 3x3 matrix."""

FLATNESS_TOLERANCE = 1e-12
"""A body is flat along an axis in which its squared extent is below this share of its largest."""

OFF_DIAGONAL_TOLERANCE = 1e-30
"""Off-diagonal entries below this share of the diagonal count as zero."""

JACOBI_PAIRS = ((0, 1), (0, 2), (1, 2))


@dataclass(frozen=True)
class Inertials:
    """The inertials of all variants of a body."""

    mass: Column
    """Mass [kg]."""

    com: list[Column]
    """Centre of mass [m], 3 columns."""

    moments: list[Column]
    """Principal moments [kg m²], 3 columns, the largest first."""

    quat: list[Column]
    """Quaternion (w, x, y, z) of the principal axes, 4 columns."""


def radii(moments: Sequence[float], quat: Sequence[float], mass: float) -> list[list[float]]:
    """Returns A (3, 3) [m] of a body with these principal moments about the axes of `quat`."""
    axes = _rotation(quat)
    # The spread of the mass along an axis is half the sum of all moments, less the moment about the axis.
    spread = [sum(moments) / 2.0 - moment for moment in moments]
    cov = [
        [sum(axes[i][k] * spread[k] * axes[j][k] for k in range(3)) / mass for j in range(3)]
        for i in range(3)
    ]
    min_pivot = FLATNESS_TOLERANCE * max(cov[k][k] for k in range(3))
    factor = [[0.0] * 3 for _ in range(3)]
    for j in range(3):
        pivot = cov[j][j] - sum(factor[j][k] * factor[j][k] for k in range(j))
        if pivot <= min_pivot:
            continue
        factor[j][j] = math.sqrt(pivot)
        for i in range(j + 1, 3):
            below = cov[i][j] - sum(factor[i][k] * factor[j][k] for k in range(j))
            factor[i][j] = below / factor[j][j]
    return factor


def moved_inertials(
    mass: Column, com: Sequence[float], a: list[list[float]], shift: Sequence[Column], transform: Rows
) -> Inertials:
    """Returns the mass properties of a body whose mass is moved. `shift`: t; `transform`: T (3, 3)."""
    centre = [c + _dot(row, shift) for c, row in zip(com, a, strict=True)]
    b = [[_dot(row, [transform[k][j] for k in range(3)]) for j in range(3)] for row in a]
    spread = [[mass * _dot(b[i], b[j]) for j in range(3)] for i in range(3)]
    values, axes = _principal(spread)
    # The moment about an axis is the spread along the other two: no triangle inequality can break.
    x, y, z = (np.maximum(value, 0.0) for value in values)
    across = [[row[2], row[1], -row[0]] for row in axes]
    return Inertials(mass, centre, [x + y, x + z, y + z], _quaternion(across))


def stretched_moments(mass: Column, a: list[list[float]], shares: Sequence[Column]) -> list[Column]:
    """Returns the moments of a body that is only stretched along its own axes, by 1 + `shares`."""
    widths = [(1.0 + share) * a[k][k] for k, share in enumerate(shares[:3])]
    x, y, z = (mass * (width * width) for width in widths)
    return [y + z, x + z, x + y]


def _dot(row: Sequence[Column | float], column: Sequence[Column | float]) -> Column:
    """Returns the sum of three products, added from left to right."""
    return np.asarray(row[0] * column[0] + row[1] * column[1] + row[2] * column[2], dtype=np.float64)


def _rotation(quat: Sequence[float]) -> list[list[float]]:
    w, x, y, z = quat
    size = w * w + x * x + y * y + z * z
    s = 2.0 / size
    return [
        [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
    ]


def _principal(symmetric: list[list[Column]]) -> tuple[list[Column], list[list[Column]]]:
    """Returns the eigenvalues of symmetric matrices, the largest first, and their right-handed axes as
    columns."""
    a = [list(row) for row in symmetric]
    unit, zero = np.ones_like(a[0][0]), np.zeros_like(a[0][0])
    axes = [[unit if i == j else zero for j in range(3)] for i in range(3)]
    for _ in range(JACOBI_SWEEPS):
        for p, q in JACOBI_PAIRS:
            _rotate(a, axes, p, q)
    return _sorted([a[k][k] for k in range(3)], axes)


def _rotate(a: list[list[Column]], axes: list[list[Column]], p: int, q: int) -> None:
    """Applies a Jacobi rotation, after which a[p][q] is 0."""
    entry = a[p][q]
    rotates = np.abs(entry) > OFF_DIAGONAL_TOLERANCE * (np.abs(a[p][p]) + np.abs(a[q][q]))
    half = (a[q][q] - a[p][p]) / np.where(rotates, 2.0 * entry, 1.0)
    size = np.abs(half)
    # There are two angles of rotation. With the smaller, at most 45 degrees, the sweeps converge.
    tangent = np.where(half < 0.0, -1.0, 1.0) / (size + np.sqrt(size * size + 1.0))
    tangent = np.where(rotates, tangent, 0.0)
    cosine = 1.0 / np.sqrt(tangent * tangent + 1.0)
    sine = tangent * cosine
    a[p][p], a[q][q] = a[p][p] - tangent * entry, a[q][q] + tangent * entry
    a[p][q] = a[q][p] = np.zeros_like(entry)
    r = 3 - p - q
    rp, rq = cosine * a[r][p] - sine * a[r][q], sine * a[r][p] + cosine * a[r][q]
    a[r][p] = a[p][r] = rp
    a[r][q] = a[q][r] = rq
    for row in axes:
        row[p], row[q] = cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]


def _sorted(values: list[Column], axes: list[list[Column]]) -> tuple[list[Column], list[list[Column]]]:
    """Returns the values from the largest to the smallest, with their axes. A swap turns an axis round, so
    that the axes stay right-handed."""
    values, axes = list(values), [list(row) for row in axes]
    for p, q in ((0, 1), (1, 2), (0, 1)):
        swap = values[p] < values[q]
        values[p], values[q] = (np.where(swap, values[q], values[p]), np.where(swap, values[p], values[q]))
        for row in axes:
            row[p], row[q] = np.where(swap, row[q], row[p]), np.where(swap, -row[p], row[q])
    return values, axes


def _quaternion(rotation: list[list[Column]]) -> list[Column]:
    """Returns the quaternions (w, x, y, z) of rotations, of unit length, with the largest part positive."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation
    # Row i holds 4 times part i times each part. The row of the largest part loses no digits by cancellation.
    rows = [
        [1.0 + xx + yy + zz, zy - yz, xz - zx, yx - xy],
        [zy - yz, 1.0 + xx - yy - zz, yx + xy, xz + zx],
        [xz - zx, yx + xy, 1.0 - xx + yy - zz, zy + yz],
        [yx - xy, xz + zx, zy + yz, 1.0 - xx - yy + zz],
    ]
    best, largest = rows[0], rows[0][0]
    for k in (1, 2, 3):
        is_larger = rows[k][k] > largest
        largest = np.where(is_larger, rows[k][k], largest)
        best = [np.where(is_larger, new, old) for new, old in zip(rows[k], best, strict=True)]
    size = np.sqrt(best[0] * best[0] + best[1] * best[1] + best[2] * best[2] + best[3] * best[3])
    return [part / size for part in best]
