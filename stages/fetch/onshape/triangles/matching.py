"""Matches meshes to parts by volume, area and centroid, where names do not identify them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

_Array = npt.NDArray[np.float64]

_FITS = 0.3
"""Largest sum of relative differences: chords cut a few hundredths off volume and area."""

_CLEAR = 0.02
"""The cost margin by which every other assignment of a mesh must be worse."""

_MOST_PAIRS = 1 << 25

_PLACE = 10.0
"""The cost of a centroid error of the mesh's own size."""

_AXES = (
    np.eye(3),
    # glTF says that y points up, CAD that z does; which of both a server follows shows in the fit.
    np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
)


@dataclass(frozen=True, slots=True, eq=False)
class BodyFigures:
    """Figures of a body, of uniform density: `volume` [m³], `area` [m²], `size` across [m].

    `centroid` (3,) [m] and `gyration`, its inertia about that by mass (3, 3) [m²], or None where
    they are not known. `name` is that of a mesh, which may be a part's id.
    """

    name: str
    volume: float
    area: float
    size: float
    centroid: _Array | None
    gyration: _Array | None


@dataclass(frozen=True, slots=True, eq=False)
class Assignment:
    """For each part that was found its mesh's index, and the rotation (3, 3) to the parts' frame.

    `certain`: whether that rotation fits clearly better than the others.
    """

    meshes: Mapping[str, int]
    rotation: _Array
    certain: bool


def assigned(meshes: Sequence[BodyFigures], parts: Mapping[str, BodyFigures]) -> Assignment:
    """The meshes of parts. A part has none where none fits, or where another would fit as well.

    ValueError where there are too many of both to try each with each.
    """
    if len(meshes) * len(parts) > _MOST_PAIRS:
        msg = f"{len(meshes)} bodies and {len(parts)} parts are too many to match"
        raise ValueError(msg)
    names = sorted(parts)
    found = []
    for rotation in _AXES:
        costs = _costs(meshes, [parts[name] for name in names], rotation)
        for row, mesh in enumerate(meshes):
            if mesh.name in parts:  # what is named by a part's id is that part
                costs[row, names.index(mesh.name)] -= _FITS
        pairs, total = _pairs(costs)
        found.append((total, {names[part]: mesh for mesh, part in pairs}, rotation))
    (total, pairing, rotation), *others = sorted(found, key=lambda one: one[0])
    return Assignment(pairing, rotation, all(other[0] - total > _CLEAR for other in others))


def _costs(meshes: Sequence[BodyFigures], parts: Sequence[BodyFigures], rotation: _Array) -> _Array:
    """(meshes, parts): the cost of each pair, a sum of relative differences."""
    costs = _apart([mesh.volume for mesh in meshes], [part.volume for part in parts])
    costs += _apart([mesh.area for mesh in meshes], [part.area for part in parts])
    for row, mesh in enumerate(meshes):
        for column, part in enumerate(parts):
            if costs[row, column] < _FITS and mesh.centroid is not None and part.centroid is not None:
                off = rotation @ mesh.centroid - part.centroid
                costs[row, column] += _PLACE * float(np.linalg.norm(off)) / max(mesh.size, 1e-9)
            if costs[row, column] < _FITS and mesh.gyration is not None and part.gyration is not None:
                off = rotation @ mesh.gyration @ rotation.T - part.gyration
                least = max(float(np.linalg.norm(part.gyration)), 1e-18)
                costs[row, column] += float(np.linalg.norm(off)) / least
    return costs


def _apart(ones: Sequence[float], others: Sequence[float]) -> _Array:
    """(ones, others): relative differences."""
    a, b = np.array(ones, dtype=np.float64)[:, None], np.array(others, dtype=np.float64)[None, :]
    return np.abs(a - b) / np.maximum(np.maximum(np.abs(a), np.abs(b)), 1e-300)


def _pairs(costs: _Array) -> tuple[list[tuple[int, int]], float]:
    """The unambiguous pairs (mesh, part) of the best assignment, and its total cost."""
    # Late: an unchanged source is not read again.
    from scipy.optimize import linear_sum_assignment

    if not costs.size:
        return [], 0.0
    bounded = np.minimum(costs, 1.0)
    rows, columns = linear_sum_assignment(bounded)
    own = bounded[rows, columns]
    # By how much the sum grows when two pairs change partners, and when a pair takes a free mesh.
    swapped = bounded[np.ix_(rows, columns)]
    grows = swapped + swapped.T - own[:, None] - own[None, :]
    np.fill_diagonal(grows, np.inf)
    clear = (grows > _CLEAR).all(axis=1)
    free = np.setdiff1d(np.arange(len(costs)), rows)
    clear &= (bounded[np.ix_(free, columns)] - own > _CLEAR).all(axis=0)
    other = np.setdiff1d(np.arange(costs.shape[1]), columns)
    clear &= (bounded[np.ix_(rows, other)] - own[:, None] > _CLEAR).all(axis=1)
    kept = clear & (own < _FITS)
    pairs = zip(rows[kept].tolist(), columns[kept].tolist(), strict=True)
    return [(int(row), int(column)) for row, column in pairs], float(own.sum())
