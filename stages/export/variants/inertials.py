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
"""A matrix (3, 3) by rows, each entry with a number for every variant, or with one number for all."""

JACOBI_SWEEPS = 8
"""Number of sweeps of Jacobi's rotations: they converge quadratically, and 5 suffice for any 3x3 matrix."""

FLATNESS_TOLERANCE = 1e-12
"""A body is flat along an axis in which its squared extent is below this share of its largest."""

OFF_DIAGONAL_TOLERANCE = 1e-30
"""Off-diagonal entries below this share of the diagonal count as zero."""

JACOBI_PAIRS = ((0, 1), (0, 2), (1, 2))
"""The pairs of axes that a sweep rotates."""


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


def spread_factor(moments: Sequence[float], quat: Sequence[float], mass: float) -> list[list[float]]:
    """Returns A (3, 3) [m] of a body of this mass [kg] with these principal moments [kg m²] about the axes of
    `quat` (w, x, y, z). A column whose pivot is negligible stays 0: the body is flat."""
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
    mass: Column, com: Sequence[float], factor: list[list[float]], shift: Sequence[Column], transform: Rows
) -> Inertials:
    """Returns the mass properties of a body whose mass is moved. `mass`: after the move; `factor`: A (3, 3);
    `shift`: t; `transform`: T (3, 3)."""
    moved_com = [coordinate + _dot(row, shift) for coordinate, row in zip(com, factor, strict=True)]
    # A T, and the covariance m (A T) (A T)ᵀ.
    moved_factor = [[_dot(row, [transform[k][j] for k in range(3)]) for j in range(3)] for row in factor]
    spread = [[mass * _dot(moved_factor[i], moved_factor[j]) for j in range(3)] for i in range(3)]
    spread_along_axes, axes = _principal(spread)
    # The moment about an axis is the spread along the other two: no triangle inequality can break.
    x, y, z = (np.maximum(value, 0.0) for value in spread_along_axes)
    # The largest moment is about the axis of the smallest spread: the axes z, y, -x are right-handed too.
    axes_of_moments = [[row[2], row[1], -row[0]] for row in axes]
    return Inertials(mass, moved_com, [x + y, x + z, y + z], _quaternion(axes_of_moments))


def stretched_moments(mass: Column, factor: list[list[float]], shares: Sequence[Column]) -> list[Column]:
    """Returns the moments about the axes of the body's frame, in their order, of a body that is only
    stretched along these axes, by 1 + `shares`."""
    widths = [(1.0 + share) * factor[k][k] for k, share in enumerate(shares[:3])]
    x, y, z = (mass * (width * width) for width in widths)
    return [y + z, x + z, x + y]


def _dot(row: Sequence[Column | float], column: Sequence[Column | float]) -> Column:
    """Returns the sum of three products, added from left to right."""
    return np.asarray(row[0] * column[0] + row[1] * column[1] + row[2] * column[2], dtype=np.float64)


def _rotation(quat: Sequence[float]) -> list[list[float]]:
    """Returns the rotation (3, 3) of a quaternion (w, x, y, z) of any length."""
    w, x, y, z = quat
    squared_length = w * w + x * x + y * y + z * z
    s = 2.0 / squared_length
    return [
        [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
    ]


def _principal(symmetric: list[list[Column]]) -> tuple[list[Column], list[list[Column]]]:
    """Returns the eigenvalues of symmetric matrices, the largest first, and their right-handed axes as
    columns."""
    matrix = [list(row) for row in symmetric]
    unit, zero = np.ones_like(matrix[0][0]), np.zeros_like(matrix[0][0])
    axes = [[unit if i == j else zero for j in range(3)] for i in range(3)]
    for _ in range(JACOBI_SWEEPS):
        for p, q in JACOBI_PAIRS:
            _rotate(matrix, axes, p, q)
    return _sorted([matrix[k][k] for k in range(3)], axes)


def _rotate(matrix: list[list[Column]], axes: list[list[Column]], p: int, q: int) -> None:
    """Applies a Jacobi rotation in place, after which matrix[p][q] is 0. An entry below
    `OFF_DIAGONAL_TOLERANCE` becomes 0 without a rotation."""
    entry, diagonal_p, diagonal_q = matrix[p][q], matrix[p][p], matrix[q][q]
    rotates = np.abs(entry) > OFF_DIAGONAL_TOLERANCE * (np.abs(diagonal_p) + np.abs(diagonal_q))
    # The cotangent of twice the angle of rotation; a division by 0 is avoided where nothing rotates.
    cotangent = (diagonal_q - diagonal_p) / np.where(rotates, 2.0 * entry, 1.0)
    size = np.abs(cotangent)
    # There are two angles of rotation. With the smaller, at most 45 degrees, the sweeps converge.
    tangent = np.where(cotangent < 0.0, -1.0, 1.0) / (size + np.sqrt(size * size + 1.0))
    tangent = np.where(rotates, tangent, 0.0)
    cosine = 1.0 / np.sqrt(tangent * tangent + 1.0)
    sine = tangent * cosine
    matrix[p][p], matrix[q][q] = diagonal_p - tangent * entry, diagonal_q + tangent * entry
    matrix[p][q] = matrix[q][p] = np.zeros_like(entry)
    r = 3 - p - q  # the third axis
    entry_p = cosine * matrix[r][p] - sine * matrix[r][q]
    entry_q = sine * matrix[r][p] + cosine * matrix[r][q]
    matrix[r][p] = matrix[p][r] = entry_p
    matrix[r][q] = matrix[q][r] = entry_q
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
    length = np.sqrt(best[0] * best[0] + best[1] * best[1] + best[2] * best[2] + best[3] * best[3])
    return [part / length for part in best]
