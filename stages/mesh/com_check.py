"""Checks that a link's centre of mass is within the convex hull of its material.

The centre of mass of a solid is inside its convex hull, and that of several solids inside their common hull.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import scipy

from linkwright.stages.formats.meshes.surface import Points
from linkwright.stages.mesh.files import stl
from linkwright.stages.mesh.part_mesh import PartMesh
from linkwright.stages.mesh.surfaces.pieces import enclosing_points
from linkwright.stages.robot.dynamics.inertia import merged, moved
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.model.robot import Array, Link, MeshRef, Part

_RELATIVE_TOLERANCE = 1e-6
"""Distance outside of the hull that counts as inside, as a share of the size."""

_MAX_POINTS = 20_000
"""Number of points above which the hull of a sample is tried first."""

Library = Callable[[Sequence[Part]], Mapping[MeshRef, PartMesh]]
"""Function that returns the meshes of parts; parts without a mesh are left out."""


def com_reports(
    links: Sequence[Link], library: Library, shapes: Sequence[Shape], files: Mapping[str, bytes]
) -> list[Diagnostic]:
    """Reports W-COM-OUTSIDE for each link whose centre of mass is outside the hull of all its parts and
    primitives.

    The `library` reads the triangles of a link's parts only if no mesh collider of the link among `shapes`
    contains the centre of mass. `files`: the meshes in STL, by name.
    """
    problems = []
    colliders: dict[str, list[bytes]] = {}
    for shape in shapes:
        if shape.role == "collision" and shape.file is not None:
            colliders.setdefault(shape.link, []).append(files[shape.file])
    for link in links:
        com = link.inertial.com
        if link.inertial.mass == 0 or _is_in_any(colliders.get(link.name, ()), com):
            continue
        problem = _check(link, library(link.parts))
        if problem is not None:
            problems.append(problem)
    return problems


def _is_in_any(files: Sequence[bytes], point: Array) -> bool:
    return any(_contains(stl.read(data), point) for data in files)


def _check(link: Link, meshes: Mapping[MeshRef, PartMesh]) -> Diagnostic | None:
    pairs = [(part, meshes[part.mesh]) for part in link.parts if part.mesh and part.mesh in meshes]
    without_mesh = [part for part in link.parts if not part.mesh or part.mesh not in meshes]
    incomplete = any(part.inertial.mass > 0 for part in without_mesh)
    if incomplete and link.given is not None:
        return None  # the centre that the user gave may lie in a part without a mesh
    com = link.inertial.com
    if incomplete:
        # The parts with a mesh must contain their own common centre of mass.
        meshed = merged([moved(part.inertial, part.link_from_part) for part, _ in pairs])
        if meshed.mass == 0:
            return None
        com = meshed.com
    points = [_moved(mesh.surface.vertices, part.link_from_part) for part, mesh in pairs]
    points += [enclosing_points(primitive) for primitive in link.shapes]
    if not points:
        return None
    cloud = np.concatenate(points)
    size = float(np.linalg.norm(np.ptp(cloud, axis=0)))
    distance = distance_outside_hull(cloud, com)
    return None if distance <= _RELATIVE_TOLERANCE * size else _diagnostic(link, pairs, distance)


def _diagnostic(link: Link, pairs: Sequence[tuple[Part, PartMesh]], distance: float) -> Diagnostic:
    wrong_parts = sorted(
        part.name for part, mesh in pairs if link.given is None and _has_com_outside_mesh(part, mesh)
    )
    message = f"the centre of mass lies {distance:.3g} m or more outside the convex hull of the link"
    hint = "check the frame of the mass properties, and look for bodies with a mass but no mesh"
    if link.given is not None or not link.parts:
        message += ", and the link's mass properties were given by the configuration"
        hint = "give com in the link's frame, in metres"
    elif wrong_parts:
        shown = ", ".join(wrong_parts[:5]) + (
            f" and {len(wrong_parts) - 5} more" if len(wrong_parts) > 5 else ""
        )
        message += f"; it is also outside the part's own mesh for: {shown}"
        hint = "check their mass properties in Onshape, such as an override of the centre of mass"
    return Diagnostic("W-COM-OUTSIDE", message, link.name, hint)


def _has_com_outside_mesh(part: Part, mesh: PartMesh) -> bool:
    """Tells whether the centre of mass of a part is outside the hull of its mesh."""
    if part.inertial.mass == 0:
        return False
    vertices = mesh.surface.vertices
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    return distance_outside_hull(vertices, part.inertial.com) > _RELATIVE_TOLERANCE * size


def distance_outside_hull(points: Points, point: Array) -> float:
    """Returns a lower bound of the distance [m] of `point` (3,) from the convex hull of `points` (n ≥ 3, 3);
    0 inside.

    The points may lie in a plane, on a line or in one place; then the distance from that counts too.
    """
    if len(points) > _MAX_POINTS and not distance_outside_hull(
        points[:: len(points) * 2 // _MAX_POINTS], point
    ):
        return 0.0  # a point in the hull of a sample is in the hull of all points
    centroid = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - centroid, full_matrices=False)
    local, target = (points - centroid) @ axes.T, (point - centroid) @ axes.T
    low, high = local.min(axis=0), local.max(axis=0)
    box_distance = float(np.linalg.norm(np.maximum(0.0, np.maximum(low - target, target - high))))
    is_wide = high - low > _RELATIVE_TOLERANCE / 10 * float((high - low).max())
    if is_wide.sum() < 2:
        return box_distance
    planes = scipy.spatial.ConvexHull(local[:, is_wide]).equations
    return max(box_distance, float((planes[:, :-1] @ target[is_wide] + planes[:, -1]).max()))


def _contains(corners: Points, point: Array) -> bool:
    """Tells whether `point` (3,) is inside a convex surface, given as triangles (m, 3, 3) in single
    precision."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    heights = np.einsum("ij,ij->i", normals, point - corners[:, 0])
    return bool((heights <= 0).all())


def _moved(points: Points, transform: Array) -> Points:
    return np.asarray(points @ transform[:3, :3].T + transform[:3, 3], dtype=np.float64)
