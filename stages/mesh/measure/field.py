"""Computes the distance from a part on a grid around it: once, to be interpolated for thousands of hulls."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from linkwright.stages.formats.meshes.surface import Points
from linkwright.stages.mesh.measure import MeasuredPart, evenly_spread, outside_part

_PITCH_TOLERANCES = 0.5
"""Distance between the nodes of the grid, in tolerances."""

_MAX_NODES = 3_000_000

_WALL_THICKNESS = 0.9
"""Distance from the part's surface, in tolerances, of nodes that form the wall between inside and outside:
well more than half of the distance between the points that represent the surface."""

_POINT_SPACING = 0.4
"""Distance between the points that represent the part, in tolerances, so small that the wall has no gap."""

_MAX_POINTS = 300_000

_TRIAL_NODES = 25
"""Number of nodes that decide whether a region is inside; if they disagree, each of its nodes is tested."""

_MAX_DISTANCE = 10.0
"""Largest distance in the field, in tolerances: well above all distances that may be allowed."""


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """The distance from a part on a grid."""

    target: MeasuredPart
    tolerance: float
    """Unit of the distances [m]."""
    pitch: float
    """Distance between the nodes [m]."""
    low: Points
    """Position of the first node (3,) [m]."""
    values: npt.NDArray[np.float32] | None
    """Distance at each node, in tolerances, 0 inside; None if the grid would have too many nodes."""

    @staticmethod
    def of(target: MeasuredPart, tolerance: float) -> Field:
        """Computes the field of a part, for distances of a few tolerances [m], exact to about a tenth of a
        tolerance."""
        pitch = _PITCH_TOLERANCES * tolerance
        low, high = target.surface.vertices.min(axis=0) - 2 * pitch, target.surface.vertices.max(axis=0)
        shape = np.ceil((high - low) / pitch).astype(np.int64) + 3
        if np.prod(shape.astype(np.float64)) > _MAX_NODES:
            return Field(target, tolerance, pitch, low, None)
        count = 2 * target.surface.area() / (_POINT_SPACING * tolerance) ** 2
        samples = evenly_spread(target.tree.corners, int(np.clip(count, 100, _MAX_POINTS))).points
        points = np.concatenate([target.surface.vertices, samples])
        flat_nodes = np.ravel_multi_index(tuple(np.rint((points - low) / pitch).astype(np.int64).T), shape)
        # The first point near a node represents the others.
        occupied, first_points = np.unique(flat_nodes, return_index=True)
        empty = np.ones(shape, dtype=bool)
        empty.ravel()[occupied] = False
        nearest = scipy.ndimage.distance_transform_edt(empty, return_distances=False, return_indices=True)
        nearest_index = np.searchsorted(occupied, np.ravel_multi_index(tuple(nearest.reshape(3, -1)), shape))
        nodes = low + pitch * np.indices(shape).reshape(3, -1).T
        distances = (
            np.linalg.norm(nodes - points[first_points[nearest_index]], axis=1).reshape(shape) / tolerance
        )
        distances[_inside_nodes(distances > _WALL_THICKNESS, nodes, target)] = 0.0
        return Field(target, tolerance, pitch, low, np.minimum(distances, _MAX_DISTANCE).astype(np.float32))

    def __call__(self, points: Points) -> npt.NDArray[np.float64]:
        """Returns the distance (n,) at points (n, 3), in tolerances, at most 10; beyond the grid, the
        distance at its border."""
        if self.values is None:
            distances, exact = outside_part(self.target, points, self.tolerance / 2)
            return np.minimum(np.where(exact, distances, 0.0) / self.tolerance, _MAX_DISTANCE)

        coordinates = ((points - self.low) / self.pitch).T
        values = scipy.ndimage.map_coordinates(self.values, coordinates, order=1, mode="nearest")
        return np.asarray(values, dtype=np.float64)


def _inside_nodes(
    is_free: npt.NDArray[np.bool_], nodes: Points, target: MeasuredPart
) -> npt.NDArray[np.bool_]:
    """Tells which nodes outside the wall (`is_free`) are inside the part. A connected region of them is
    usually inside or outside as a whole."""
    regions, count = scipy.ndimage.label(is_free)
    region_of_node = regions.ravel()
    order = np.argsort(region_of_node, kind="stable")
    ends = np.searchsorted(region_of_node[order], np.arange(1, count + 2))
    result = np.zeros(region_of_node.shape, dtype=bool)
    for begin, end in itertools.pairwise(ends):
        members = order[begin:end]
        trial = target.inside(nodes[members[np.linspace(0, len(members) - 1, _TRIAL_NODES).astype(np.int64)]])
        trial_agrees = trial.all() or not trial.any()
        result[members] = trial[0] if trial_agrees else target.inside(nodes[members])
    return np.asarray(result.reshape(is_free.shape))
