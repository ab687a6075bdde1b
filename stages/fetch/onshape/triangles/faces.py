"""Reads Onshape's tessellated faces from their JSON, which takes about 300 bytes a triangle.

Reads both envelopes (an object with `bodies`, a bare list) and both forms of facets (`indices` into
the body's `facetPoints`, `vertices` of their own), piece by piece into arrays.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from operator import itemgetter
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.fetch.onshape.api.http_errors import Declined
from linkwright.stages.fetch.onshape.triangles import json_stream
from linkwright.stages.fetch.onshape.triangles.json_stream import Document, MalformedError
from linkwright.stages.formats import triangles
from linkwright.stages.formats.colours import colour_of
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.formats.meshes.body_arrays import Body
from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.geometry import Colour

_Record = Mapping[str, Any]
_Points = npt.NDArray[np.float64]
_Indices = npt.NDArray[np.int64]
_XYZ = itemgetter("x", "y", "z")
_BATCH = 4096
"""Number of facets that are converted to arrays together."""

_MAX_MEAN_CORNERS = 16
"""Mean number of corners of a facet above which a batch has fewer facets."""

_HINT = "run the same command again; if it fails each time, the API has changed"

MAX_TRIANGLES = 1 << 24
"""Largest number of triangles in a reply: five times that of the largest reply that CAD writes."""

MAX_BODIES = 1 << 16
"""Largest number of bodies in a reply."""


@dataclass(slots=True)
class MemoryBudget:
    """The numbers of triangles, points and bodies that a reply may still have: a few bytes of text can
    describe many triangles."""

    triangles: int = MAX_TRIANGLES
    points: int = 3 * MAX_TRIANGLES
    bodies: int = MAX_BODIES

    def take(self, *, triangles: int = 0, points: int = 0, bodies: int = 0) -> None:
        """Subtracts these numbers, before memory is allocated for them. Raises Declined if too few are
        left."""
        self.triangles -= triangles
        self.points -= points
        self.bodies -= bodies
        if min(self.triangles, self.points, self.bodies) < 0:
            msg = f"the reply with triangles has more than {MAX_TRIANGLES} triangles or {MAX_BODIES} bodies"
            raise Declined(msg, hint="use a coarser source.tessellation")


def compact(reply: bytes) -> bytes:
    """Returns the compact form of a reply with tessellated faces; a reply in that form is returned unchanged.

    Raises ProtocolError if the reply is not JSON, has no bodies, or has a body in no known shape.
    """
    if triangles.is_compact(reply):
        triangles.require_compact(reply)
        return reply
    try:
        return body_arrays.encode(read(reply))
    except ValueError as error:  # too many colours
        raise ProtocolError(str(error), hint=_HINT) from None


def read(reply: bytes) -> list[Body]:
    """Returns the bodies of a reply in order; a body may have no triangles. Raises the errors of `compact`.

    A composite part is its own triangles, or else those of its constituents.
    """
    room = MemoryBudget()
    try:
        root = Document(reply).root()
        envelope = root if isinstance(root, dict) else {}
        records = envelope.get("bodies") if envelope else root
        if not isinstance(records, list | json_stream.Pieces):
            msg = "the reply with triangles has no bodies"
            raise ProtocolError(msg, hint=_HINT)
        shared = _points(envelope.get("facetPoints"), room)
        bodies, composites = [], dict[str, frozenset[str]]()
        for body in json_stream.elements(records):
            name = body.get("id") if isinstance(body, dict) else None
            if isinstance(name, str):
                room.take(bodies=1)
                bodies.append(_checked_body(name, body, shared, room))
                listing = json_stream.elements(body.get("constituents"))
                composites[name] = frozenset(ident for ident in listing if isinstance(ident, str))
    except MalformedError as error:
        msg = f"the reply with triangles is not JSON, or was cut short: {error}"
        raise ProtocolError(msg, hint=_HINT) from None
    bodies_with_triangles = [body for body in bodies if len(body.triangles)]
    return [_with_constituents(body, composites[body.id], bodies_with_triangles, room) for body in bodies]


def _with_constituents(
    body: Body, constituents: frozenset[str], bodies_with_triangles: Sequence[Body], room: MemoryBudget
) -> Body:
    """Returns a composite without triangles of its own with those of its constituents, and any other body
    unchanged."""
    if not constituents or len(body.triangles):
        return body
    parts = [part for part in bodies_with_triangles if part.id in constituents]
    if not parts:
        return body
    for part in parts:
        room.take(triangles=len(part.triangles), points=len(part.points))
    first_points = np.cumsum([0, *(len(part.points) for part in parts)])
    first_colours = np.cumsum([0, *(len(part.palette) for part in parts)])
    return body_arrays.merged(
        body.id,
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.triangles + offset for part, offset in zip(parts, first_points, strict=False)]),
        [colour for part in parts for colour in part.palette],
        np.concatenate([part.colours + offset for part, offset in zip(parts, first_colours, strict=False)]),
    )


def _checked_body(name: str, record: _Record, shared: _Points, room: MemoryBudget) -> Body:
    try:
        return _body(name, record, shared, room)
    except MalformedError:
        raise
    except (AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError) as error:
        msg = f"the reply with triangles has an unknown format ({type(error).__name__}: {error})"
        raise ProtocolError(msg, f"part {name}", _HINT) from error


def _body(name: str, record: _Record, shared: _Points, room: MemoryBudget) -> Body:
    own_points = _points(record.get("facetPoints"), room)
    if not len(own_points):
        room.take(points=len(shared))
    soup = _FacetCollector(own_points if len(own_points) else shared, room)
    colours: list[Colour] = []
    for face in json_stream.elements(record.get("faces")):
        for facets in json_stream.runs(face.get("facets")):
            soup.add(facets, len(colours))
        colours.append(colour_of(face.get("appearance"), record.get("appearance")))
    return body_arrays.merged(name, *soup.joined(), colours, soup.faces())


class _FacetCollector:
    """Collects the facets of a body in batches: faces have few facets, and arrays are efficient for many.

    `table` (n, 3): the points that indices refer to.
    """

    def __init__(self, table: _Points, room: MemoryBudget) -> None:
        self._room = room
        self._table = len(table)
        self._points, self._point_count = [table], len(table)
        self._corners = [np.empty((0, 3), dtype=np.int64)]
        self._faces = [np.empty(0, dtype=np.int64)]
        self._facets: list[_Record] = []
        self._face: list[int] = []
        self._waiting = 0

    def add(self, facets: Sequence[_Record], face: int) -> None:
        """Adds facets of the face with this number."""
        self._facets += facets
        self._face += [face] * len(facets)
        self._waiting += sum(len(facet.get("indices") or facet.get("vertices") or ()) for facet in facets)
        if max(len(self._facets), self._waiting // _MAX_MEAN_CORNERS) >= _BATCH:
            self._flush()

    def joined(self) -> tuple[_Points, _Indices]:
        """Returns all points (n, 3), and the corners (m, 3) of all triangles among them."""
        self._flush()
        points, corners = np.concatenate(self._points), np.concatenate(self._corners)
        self._points, self._corners = [points], [corners]
        return points, corners

    def faces(self) -> _Indices:
        """Returns the number of each triangle's face (m,)."""
        self._flush()
        return np.concatenate(self._faces)

    def _flush(self) -> None:
        if not self._facets:
            return
        facets, face = self._facets, np.array(self._face, dtype=np.int64)
        self._facets, self._face, self._waiting = [], [], 0
        rows = [facet.get("indices") or () for facet in facets] if self._table else [()] * len(facets)
        lengths = np.fromiter(map(len, rows), dtype=np.int64, count=len(rows))
        self._room.take(triangles=_triangles(lengths))
        corners = np.fromiter(chain.from_iterable(rows), dtype=np.int64, count=int(lengths.sum()))
        if len(corners) and not 0 <= corners.min() <= corners.max() < self._table:
            msg = f"an index lies outside of the {self._table} points"
            raise IndexError(msg)
        self._keep(corners, lengths, face)
        if not lengths.all():  # facets without indices bring points of their own
            pairs = zip(facets, rows, strict=True)
            corners_of_facets = [() if row else facet.get("vertices") or () for facet, row in pairs]
            own_lengths = np.fromiter(
                map(len, corners_of_facets), dtype=np.int64, count=len(corners_of_facets)
            )
            self._room.take(triangles=_triangles(own_lengths), points=int(own_lengths.sum()))
            own_points = _array(list(chain.from_iterable(corners_of_facets)))
            self._keep(np.arange(self._point_count, self._point_count + len(own_points)), own_lengths, face)
            self._points.append(own_points)
            self._point_count += len(own_points)

    def _keep(self, corners: _Indices, lengths: _Indices, face: _Indices) -> None:
        fan, owner = _fan(corners, lengths)
        self._corners.append(fan)
        self._faces.append(face[owner])


def _triangles(lengths: _Indices) -> int:
    """Returns the number of triangles of polygons with these numbers of corners."""
    return int(np.maximum(lengths - 2, 0).sum())


def _fan(corners: _Indices, lengths: _Indices) -> tuple[_Indices, _Indices]:
    """Splits polygons, their corners end to end, into triangles (m, 3); returns also the polygon of each
    (m,).

    A polygon with more than three corners becomes a fan.
    """
    counts = np.maximum(lengths - 2, 0)
    owner = np.repeat(np.arange(len(lengths)), counts)
    start = (np.cumsum(lengths) - lengths)[owner]
    step = np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]
    corner_indices = np.stack([start, start + step + 1, start + step + 2], axis=1)
    return corners[corner_indices].reshape(-1, 3), owner


def _points(records: Any, room: MemoryBudget) -> _Points:
    """Returns the points (n, 3) in an array of points, large or small."""
    pieces = [np.empty((0, 3))]
    for run in json_stream.runs(records):
        room.take(points=len(run))
        pieces.append(_array(run))
    return np.concatenate(pieces)


def _array(records: Sequence[Any]) -> _Points:
    """Returns the points (n, 3) in {x, y, z} mappings or in lists of three."""
    if not records:
        return np.empty((0, 3))
    rows = list(map(_XYZ, records)) if isinstance(records[0], dict) else records
    if set(map(len, rows)) != {3}:
        msg = "a point does not have three coordinates"
        raise ValueError(msg)
    # Flat, since a list of numbers becomes an array several times faster than a list of lists.
    points = np.array(list(chain.from_iterable(rows)), dtype=np.float64).reshape(-1, 3)
    if not np.isfinite(points).all():
        msg = "a coordinate is not a finite number"
        raise ValueError(msg)
    return points
