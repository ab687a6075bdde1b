"""Fewer triangles for a robot that has more than there are pixels."""

import numpy as np

from linkwright.stages.show.clusters import cell_means
from linkwright.stages.show.raster import Corners


def thinned(corners: Corners, cell: float) -> Corners:
    """Triangles (m, 3, 3) of which the corners in each cell of a grid, `cell` wide, are one: their mean.
    Those that have two corners in a cell are left out, and of equal ones all but one."""
    points = corners.reshape(-1, 3)
    steps = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    means, place = cell_means(points, steps)
    faces = np.sort(place.reshape(-1, 3), axis=1)
    real = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])
    number = len(means)
    keys = (faces[real, 0] * number + faces[real, 1]) * number + faces[real, 2]
    _, first = np.unique(keys, return_index=True)
    found: Corners = means[faces[real][first]]
    return found
