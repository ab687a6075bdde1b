"""Makes shapes for a robot without shapes: a ball at each body, and a bone to its parent."""

from collections.abc import Iterator, Sequence

import numpy as np

from linkwright.stages.show.preview.look import Geom
from linkwright.stages.show.preview.vectors import vector
from linkwright.stages.show.raster import Numbers

_BONE_COLOUR = (0.45, 0.49, 0.54, 1.0)
_JOINT_COLOUR = (0.93, 0.45, 0.16, 1.0)
"""Colours of bones, and of joints."""


def bones(positions: Numbers, parents: Sequence[int | None]) -> Iterator[Geom]:
    """Yields the shapes for bodies at `positions` (n, 3) [m]. `parents`: the row of each body's parent, None
    without a parent."""
    extent = float(np.ptp(positions, axis=0).max()) or 0.1
    for position, parent in zip(positions, parents, strict=True):
        ball = (0.035 * extent,) * 3
        yield Geom("ellipsoid", ball, vector(position), vector(np.eye(3)), _JOINT_COLOUR)
        offset = position - positions[parent] if parent is not None else np.zeros(3)
        length = float(np.linalg.norm(offset))
        if length > 0:
            z = offset / length
            x = np.cross(z, np.eye(3)[int(np.abs(z).argmin())])
            x = x / np.linalg.norm(x)
            rotation = np.stack([x, np.cross(z, x), z], axis=1)
            size = (0.014 * extent, length / 2)
            yield Geom("capsule", size, vector(position - offset / 2), vector(rotation), _BONE_COLOUR)
