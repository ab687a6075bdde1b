"""Computes the inertia of a link's shapes as solids."""

from collections.abc import Iterable, Iterator

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull, QhullError

from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.formats.urdf.model import UrdfShape, mesh_key
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.dynamics.inertia import (
    merged,
    moved,
    primitive_inertial,
    primitive_volume,
    solid_inertia,
)
from linkwright.stages.robot.model.robot import Array, Inertial


def solid_of(shapes: Iterable[UrdfShape], bundle: Bundle) -> Inertial | None:
    """Returns the inertial of the shapes as solids of density 1, in the link's frame; a mesh that is not
    closed counts as its convex hull. Returns None if no shape has a volume."""
    solids = [moved(solid, shape.link_from_shape) for shape in shapes for solid in _solids(shape, bundle)]
    return merged(solids) if solids else None


def _solids(shape: UrdfShape, bundle: Bundle) -> Iterator[Inertial]:
    if shape.kind != "mesh":
        volume = primitive_volume(shape.kind, shape.size)
        if volume > 0:
            yield primitive_inertial(shape.kind, shape.size, volume)
        return
    key = mesh_key(shape)
    digest = bundle.requests.get(f"mesh/{key}")
    body = body_arrays.decode(bundle.body(digest), [key]).get(key) if digest else None
    if body is None or not len(body.triangles):
        return
    points, index = body_arrays.distinct(body.points)
    corners = index[body.triangles]
    try:
        yield solid_inertia(*((points, corners) if _is_closed(corners) else _hull(points)), 1.0)
    except ValueError:
        return  # flat, so it holds nothing


def _is_closed(corners: npt.NDArray[np.int64]) -> bool:
    """Tells whether every edge of the triangles (m, 3) occurs equally often in both directions."""
    edges = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2)
    forth, back = edges[np.lexsort(edges.T)], edges[:, ::-1]
    return bool(np.array_equal(forth, back[np.lexsort(back.T)]))


def _hull(points: Array) -> tuple[Array, npt.NDArray[np.int64]]:
    """Returns the convex hull's points and triangles, facing outwards; raises ValueError if the points are
    flat."""
    try:
        hull = ConvexHull(points)
    except QhullError as error:
        raise ValueError(str(error)) from None
    corners = hull.simplices.astype(np.int64)
    a, b, c = np.moveaxis(points[corners], 1, 0)
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    corners[inwards] = corners[inwards][:, ::-1]
    return points, corners
