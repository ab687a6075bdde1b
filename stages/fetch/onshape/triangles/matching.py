"""Matches meshes to parts by volume, area and centroid, if names do not identify them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

_Array = npt.NDArray[np.float64]

_MAX_COST = 0.3
"""Largest sum of relative differences of a match: chords cut a few hundredths off volume and area."""

_MIN_MARGIN = 0.02
"""Cost margin by which every other assignment of a mesh must be worse."""

_MAX_PAIRS = 1 << 25
"""Largest number of pairs of meshes and parts that are tried."""

_CENTROID_WEIGHT = 10.0
"""Cost of a centroid error of the mesh's own size."""

_ROTATIONS = (
    np.eye(3),
    # In glTF y points up, in CAD z does; the fit shows which of both a server follows.
    np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
)
"""The rotations from the meshes' to the parts' frame that are tried."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyFigures:
    """Figures of a body of uniform density."""

    name: str
    """The name of the mesh, which may be a part's id."""

    volume: float
    """Volume [m³]."""

    area: float
    """Surface area [m²]."""

    size: float
    """Size across [m]."""

    centroid: _Array | None
    """Centroid (3,) [m]; None if it is not known."""

    gyration: _Array | None
    """Inertia about the centroid, divided by the mass (3, 3) [m²]; None if it is not known."""


@dataclass(frozen=True, slots=True, eq=False)
class Assignment:
    """The meshes of parts, and the frame of the meshes."""

    meshes: Mapping[str, int]
    """Part → the index of its mesh."""

    rotation: _Array
    """Rotation (3, 3) from the meshes' frame to the parts'."""

    is_certain: bool
    """Whether this rotation fits clearly better than the others."""


def assign_meshes(meshes: Sequence[BodyFigures], parts: Mapping[str, BodyFigures]) -> Assignment:
    """Assigns meshes to parts. A part has no mesh if none fits, or if several fit equally well.

    Raises ValueError if there are too many pairs of meshes and parts to try.
    """
    if len(meshes) * len(parts) > _MAX_PAIRS:
        msg = f"{len(meshes)} bodies and {len(parts)} parts are too many to match"
        raise ValueError(msg)
    names = sorted(parts)
    fits = []
    for rotation in _ROTATIONS:
        costs = _costs(meshes, [parts[name] for name in names], rotation)
        for row, mesh in enumerate(meshes):
            if mesh.name in parts:  # a mesh that is named by a part's id is that part
                costs[row, names.index(mesh.name)] -= _MAX_COST
        pairs, total = _pairs(costs)
        fits.append((total, {names[part]: mesh for mesh, part in pairs}, rotation))
    (total, pairing, rotation), *other_fits = sorted(fits, key=lambda fit: fit[0])
    return Assignment(pairing, rotation, all(other[0] - total > _MIN_MARGIN for other in other_fits))


def _costs(meshes: Sequence[BodyFigures], parts: Sequence[BodyFigures], rotation: _Array) -> _Array:
    """Returns the cost (meshes, parts) of each pair, a sum of relative differences."""
    costs = _relative_differences([mesh.volume for mesh in meshes], [part.volume for part in parts])
    costs += _relative_differences([mesh.area for mesh in meshes], [part.area for part in parts])
    for row, mesh in enumerate(meshes):
        for column, part in enumerate(parts):
            if costs[row, column] < _MAX_COST and mesh.centroid is not None and part.centroid is not None:
                difference = rotation @ mesh.centroid - part.centroid
                costs[row, column] += (
                    _CENTROID_WEIGHT * float(np.linalg.norm(difference)) / max(mesh.size, 1e-9)
                )
            if costs[row, column] < _MAX_COST and mesh.gyration is not None and part.gyration is not None:
                difference = rotation @ mesh.gyration @ rotation.T - part.gyration
                part_norm = max(float(np.linalg.norm(part.gyration)), 1e-18)
                costs[row, column] += float(np.linalg.norm(difference)) / part_norm
    return costs


def _relative_differences(first: Sequence[float], second: Sequence[float]) -> _Array:
    """Returns the relative differences (n, m) of each pair of numbers."""
    a, b = np.array(first, dtype=np.float64)[:, None], np.array(second, dtype=np.float64)[None, :]
    return np.abs(a - b) / np.maximum(np.maximum(np.abs(a), np.abs(b)), 1e-300)


def _pairs(costs: _Array) -> tuple[list[tuple[int, int]], float]:
    """Returns the unambiguous pairs (mesh, part) of the best assignment, and its total cost."""

    if not costs.size:
        return [], 0.0
    bounded = np.minimum(costs, 1.0)
    rows, columns = scipy.optimize.linear_sum_assignment(bounded)
    pair_costs = bounded[rows, columns]
    # The growth of the sum when two pairs exchange partners, and when a pair takes a free mesh.
    swapped = bounded[np.ix_(rows, columns)]
    cost_growth = swapped + swapped.T - pair_costs[:, None] - pair_costs[None, :]
    np.fill_diagonal(cost_growth, np.inf)
    is_clear = (cost_growth > _MIN_MARGIN).all(axis=1)
    free_meshes = np.setdiff1d(np.arange(len(costs)), rows)
    is_clear &= (bounded[np.ix_(free_meshes, columns)] - pair_costs > _MIN_MARGIN).all(axis=0)
    free_parts = np.setdiff1d(np.arange(costs.shape[1]), columns)
    is_clear &= (bounded[np.ix_(rows, free_parts)] - pair_costs[:, None] > _MIN_MARGIN).all(axis=1)
    is_pair = is_clear & (pair_costs < _MAX_COST)
    pairs = zip(rows[is_pair].tolist(), columns[is_pair].tolist(), strict=True)
    return [(int(row), int(column)) for row, column in pairs], float(pair_costs.sum())
