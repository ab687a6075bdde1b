"""Triangles out of Onshape's tessellated faces, in the part studio's frame."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from operator import itemgetter
from typing import Any

import numpy as np
import numpy.typing as npt
import orjson

from stages.mesh.appearance import colour_of
from stages.mesh.surface import Points, Surface, Triangles, weld
from stages.robot.errors import ProtocolError
from stages.robot.geometry import Colour

_Record = Mapping[str, Any]
_XYZ = itemgetter("x", "y", "z")


@dataclass(frozen=True, slots=True, eq=False)
class PartMesh:
    """One part's triangles, welded, in the part's own frame.

    `palette`: the part's colours, sorted; `colours` (m,): each triangle's index in it.
    `closed`: whether the surface bounds a solid; `volume` [m³] is 0 where it does not.
    """

    surface: Surface
    palette: tuple[Colour, ...]
    colours: npt.NDArray[np.int64]
    closed: bool
    volume: float


def read(body: bytes, parts: Collection[str]) -> dict[str, PartMesh]:
    """The meshes of `parts` that a reply has; a part without triangles is absent.

    Reads both envelopes (an object with `bodies`, a bare list) and both forms of facets (`indices`
    into the body's `facetPoints`, `vertices` of their own). ProtocolError names what is wrong.
    """
    try:
        data = orjson.loads(body)
    except orjson.JSONDecodeError as error:
        msg = f"the reply with triangles is not JSON: {error}"
        raise ProtocolError(msg, hint=_HINT) from None
    shared = data.get("facetPoints") if isinstance(data, dict) else None
    bodies = data.get("bodies") if isinstance(data, dict) else data
    meshes: dict[str, PartMesh] = {}
    for record in bodies if isinstance(bodies, list) else ():
        name = record.get("id") if isinstance(record, dict) else None
        if not isinstance(name, str) or name not in parts or name in meshes:
            continue
        try:
            mesh = _part(record, shared or ())
        except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
            msg = f"the triangles are not in a known shape ({type(error).__name__}: {error})"
            raise ProtocolError(msg, f"part {name}", _HINT) from error
        if mesh is not None:
            meshes[name] = mesh
    return meshes


_HINT = "fetch again with source.refresh=true; if it fails each time, the API has changed"


def _part(record: _Record, shared: Sequence[Any]) -> PartMesh | None:
    body_points = record.get("facetPoints") or shared
    facets: list[_Record] = []
    faces: list[tuple[Colour, int]] = []
    for face in record.get("faces") or ():
        found = face.get("facets") or ()
        facets += found
        faces.append((colour_of(face.get("appearance"), record.get("appearance")), len(found)))
    points, triangles, owner = _triangles(facets, body_points)
    palette = tuple(sorted({colour for colour, _ in faces}))
    rank = {colour: index for index, colour in enumerate(palette)}
    by_facet = np.repeat([rank[colour] for colour, _ in faces], [count for _, count in faces])
    surface, kept = weld(points, triangles)
    if not len(surface.triangles):
        return None
    colours = by_facet[owner[kept]].astype(np.int64)
    closed = surface.closed()
    volume = surface.volume()
    if volume < 0:
        surface, volume = surface.flipped(), -volume
    return PartMesh(surface, palette, colours, closed, volume)


def _triangles(
    facets: Sequence[_Record], body_points: Sequence[Any]
) -> tuple[Points, Triangles, npt.NDArray[np.int64]]:
    """Points, triangles over them, and the facet that each triangle belongs to.

    A facet with more than three corners becomes a fan.
    """
    rows = [facet.get("indices") or () for facet in facets] if body_points else [() for _ in facets]
    lengths = np.array([len(row) for row in rows], dtype=np.int64)
    corners = np.fromiter(chain.from_iterable(rows), dtype=np.int64, count=int(lengths.sum()))
    points = _points(body_points)
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
        msg = f"an index lies outside of the {len(points)} points"
        raise IndexError(msg)
    # Facets without indices bring points of their own, which are appended.
    own = [
        facet.get("vertices") or () if not length else ()
        for facet, length in zip(facets, lengths, strict=True)
    ]
    own_lengths = np.array([len(row) for row in own], dtype=np.int64)
    first_own = len(points)
    points = np.concatenate([points, _points(list(chain.from_iterable(own)))])
    indexed, owner = _fan(corners, lengths)
    loose, loose_owner = _fan(np.arange(first_own, len(points), dtype=np.int64), own_lengths)
    return points, np.concatenate([indexed, loose]), np.concatenate([owner, loose_owner])


def _fan(
    corners: npt.NDArray[np.int64], lengths: npt.NDArray[np.int64]
) -> tuple[Triangles, npt.NDArray[np.int64]]:
    """Polygons, their corners end to end, as triangles (m, 3) and the polygon of each (m,)."""
    counts = np.maximum(lengths - 2, 0)
    owner = np.repeat(np.arange(len(lengths)), counts)
    start = (np.cumsum(lengths) - lengths)[owner]
    step = np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]
    picks = np.stack([start, start + step + 1, start + step + 2], axis=1)
    return corners[picks].reshape(-1, 3), owner


def _points(records: Sequence[Any]) -> Points:
    """(n, 3) from {x, y, z} mappings or from lists of three."""
    if not records:
        return np.empty((0, 3))
    rows = list(map(_XYZ, records)) if isinstance(records[0], dict) else list(records)
    points = np.array(rows, dtype=np.float64).reshape(len(rows), 3)
    if not np.isfinite(points).all():
        msg = "a coordinate is not a finite number"
        raise ValueError(msg)
    return points
