"""Reads a part studio's triangles from its glTF: the alternative to tessellated faces.

Its coordinates have single precision. Neither the names of its nodes nor the direction of its up axis is
documented, so its bodies are identified, and its up axis is found, by comparing volumes, areas, centroids and
inertias with the mass properties of the studio.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import orjson

from linkwright.stages.fetch.onshape.triangles.matching import BodyFigures, assign_meshes
from linkwright.stages.formats.meshes import body_arrays, gltf
from linkwright.stages.formats.meshes.gltf import Node
from linkwright.stages.robot.errors import ProtocolError

_MIN_VOLUME_SHARE = 1e-9
"""Volumes of meshes up to this share of the cube of their size count as no volume."""

_HINT = "run the same command again; if it fails each time, the API has changed"


def compact(reply: bytes, mass: bytes) -> bytes:
    """Returns the compact form of a glTF reply; `mass` is the reply with the mass properties of the parts.

    Parts that no body fits, or that several fit equally well, are left out. Raises ProtocolError if the reply
    is no such file, if no body fits, or if the parts do not determine the up axis.
    """
    nodes = [node for node in gltf.read(reply) if len(node.corners)]
    parts = _parts(mass)
    if not nodes or not parts:
        return body_arrays.encode([])
    try:
        assignment = assign_meshes([_figures_of_node(node) for node in nodes], parts)
    except ValueError as error:
        raise ProtocolError(str(error), hint=_HINT) from None
    if not assignment.meshes:
        msg = f"none of the {len(nodes)} bodies of the glTF fits one of the {len(parts)} parts"
        raise ProtocolError(msg, hint=_HINT)
    if not assignment.is_certain:
        msg = "the bodies of the glTF fit the parts with either axis up"
        raise ProtocolError(
            msg, hint="give the parts materials in Onshape, so that Onshape reports their centres of mass"
        )
    bodies = []
    for name in sorted(assignment.meshes):
        node = nodes[assignment.meshes[name]]
        points = _rotated(node.points, assignment.rotation)
        bodies.append(body_arrays.merged(name, points, node.corners, node.colours, node.which))
    return body_arrays.encode(bodies)


def _rotated(points: npt.NDArray[np.float64], rotation: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Returns the points (n, 3) under a rotation by right angles, exactly."""
    x, y, z = points.T
    return np.stack([row[0] * x + row[1] * y + row[2] * z for row in rotation], axis=1)


def _figures_of_node(node: Node) -> BodyFigures:
    """Returns the figures of a node's mesh; centroid and gyration are None if it encloses no volume."""
    centre_of_box = (node.points.min(axis=0) + node.points.max(axis=0)) / 2
    corners = (node.points - centre_of_box)[node.corners]
    a, b, c = np.moveaxis(corners, 1, 0)
    area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
    size = float(np.linalg.norm(np.ptp(node.points, axis=0)))
    # Signed volumes of the tetrahedra between the middle and the triangles.
    signed_volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    volume = float(signed_volumes.sum())
    if abs(volume) <= _MIN_VOLUME_SHARE * size**3:
        return BodyFigures(node.name, abs(volume), area, size, None, None)
    corner_sums = a + b + c
    # The centroid of a tetrahedron is the mean of its four corners, of which the middle is 0.
    centre = signed_volumes @ corner_sums / (4 * volume)
    # Second moments of tetrahedra with a corner at 0: V / 20 (Σ v vᵀ + s sᵀ), s the sum of the corners v.
    second_moment = np.einsum("k,kia,kib->ab", signed_volumes, corners, corners) + np.einsum(
        "k,ka,kb->ab", signed_volumes, corner_sums, corner_sums
    )
    second_moment = second_moment / (20 * volume) - np.outer(centre, centre)
    # From second moments about the centroid to the inertia tensor.
    gyration = np.trace(second_moment) * np.eye(3) - second_moment
    return BodyFigures(node.name, abs(volume), area, size, centre_of_box + centre, gyration)


def _parts(mass: bytes) -> dict[str, BodyFigures]:
    """Returns the figures that CAD gives, by part id; without a mass it gives no centroid and no inertia."""
    try:
        bodies: Mapping[str, Mapping[str, Any]] = orjson.loads(mass)["bodies"]
        return {name: _figures_of_part(name, record) for name, record in bodies.items()}
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        msg = f"the mass properties do not identify the parts ({type(error).__name__}: {error})"
        raise ProtocolError(msg, hint=_HINT) from None


def _figures_of_part(name: str, record: Mapping[str, Any]) -> BodyFigures:
    volume, area, weight = (float(record[key][0]) for key in ("volume", "periphery", "mass"))
    if not record.get("hasMass") or weight <= 0:
        return BodyFigures(name, volume, area, 0.0, None, None)
    centroid = np.array(record["centroid"][:3], dtype=np.float64)
    inertia = np.array(record["inertia"][:9], dtype=np.float64).reshape(3, 3)
    return BodyFigures(name, volume, area, 0.0, centroid, inertia / weight)
