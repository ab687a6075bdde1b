"""Reduces the triangles of a robot with more details than the picture has pixels."""

import numpy as np

from linkwright.stages.show.clusters import cell_means
from linkwright.stages.show.raster import Corners


def merge_details(corners: Corners, cell: float) -> Corners:
    """Merges the corners of triangles (m, 3, 3) in each cell of a grid, `cell` wide, to their mean. Drops
    triangles with two corners in a cell, and duplicates."""
    points = corners.reshape(-1, 3)
    steps = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    means, index = cell_means(points, steps)
    faces = np.sort(index.reshape(-1, 3), axis=1)
    has_area = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])
    number = len(means)
    keys = (faces[has_area, 0] * number + faces[has_area, 1]) * number + faces[has_area, 2]
    _, first = np.unique(keys, return_index=True)
    merged_corners: Corners = means[faces[has_area][first]]
    return merged_corners
