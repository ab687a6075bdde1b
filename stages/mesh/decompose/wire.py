"""Surfaces and decompositions as bytes: what goes to the guest, comes from it, and is cached."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stages.mesh.surface import Points, Surface, Triangles

_LENGTH = struct.Struct("<Q")


@dataclass(frozen=True, slots=True)
class Joining:
    """Two groups of pieces become one, and what that costs [m³]: how much more volume their common hull has
    than they, and more where it stands out of the part too far.

    A group is named by a number: the pieces come first, then the joinings in their order.
    """

    first: int
    second: int
    cost: float


@dataclass(frozen=True, slots=True, eq=False)
class Decomposition:
    """A part as convex pieces, finer than asked for, and how they may be joined down to one.

    `pieces`: the corners (n, 3) of each [m]. `way`: how the mesh was made fit for it: "as it is" or
    "remeshed". `volume` [m³] is the part's. `refused`: why there are no pieces, where that follows from the
    mesh itself.
    """

    pieces: tuple[Points, ...]
    joinings: tuple[Joining, ...]
    way: str
    faces: int
    volume: float
    refused: str = ""


def refusal(reason: str) -> Decomposition:
    """What is known of a mesh that has no pieces."""
    return Decomposition((), (), "", 0, 0.0, reason)


def pack(head: Mapping[str, Any], arrays: Sequence[npt.NDArray[Any]]) -> bytes:
    """A line of JSON, which gets the lengths of the (n, 3) arrays, and the arrays."""
    lengths = [len(one) for one in arrays]
    line = json.dumps({**head, "lengths": lengths}, sort_keys=True).encode()
    return b"".join([_LENGTH.pack(len(line)), line, *(np.ascontiguousarray(one).tobytes() for one in arrays)])


def _parts(data: bytes) -> tuple[dict[str, Any], memoryview]:
    (length,) = _LENGTH.unpack_from(data)
    rest = memoryview(data)[_LENGTH.size :]
    if length > len(rest):
        raise ValueError("cut off")
    head = json.loads(bytes(rest[:length]))
    if not isinstance(head, dict):
        raise ValueError("no head")
    return head, rest[length:]


def request(surface: Surface, head: Mapping[str, Any]) -> bytes:
    return pack(head, [surface.vertices.astype("<f8"), surface.triangles.astype("<i8")])


def read_request(data: bytes) -> tuple[dict[str, Any], Points, Triangles]:
    """The head, the vertices and the triangles of a request."""
    head, body = _parts(data)
    points, triangles = head["lengths"]
    cut = points * 24
    vertices = np.frombuffer(body[:cut], "<f8").reshape(points, 3)
    corners = np.frombuffer(body[cut:], "<i8").reshape(triangles, 3)
    # Copies: the libraries that get them refuse what cannot be written to.
    return head, vertices.copy(), corners.copy()


def write(made: Decomposition) -> bytes:
    head = {
        "joinings": [[one.first, one.second, one.cost] for one in made.joinings],
        "way": made.way,
        "faces": made.faces,
        "volume": made.volume,
        "refused": made.refused,
    }
    return pack(head, [piece.astype("<f8") for piece in made.pieces])


def read(data: bytes) -> Decomposition:
    """The decomposition that `write` wrote; ValueError where these bytes are none."""
    try:
        head, body = _parts(data)
        lengths = [int(length) for length in head["lengths"]]
        points = np.frombuffer(body, "<f8").reshape(-1, 3)
        if min(lengths, default=0) < 0 or sum(lengths) != len(points) or not np.isfinite(points).all():
            raise ValueError("other lengths, or numbers that are none")
        joinings = tuple(Joining(int(a), int(b), float(cost)) for a, b, cost in head["joinings"])
        for count, one in enumerate(joinings, len(lengths)):
            if not (0 <= one.first < one.second < count and math.isfinite(one.cost)):
                raise ValueError("a joining of what is not there")
        if len({number for one in joinings for number in (one.first, one.second)}) != 2 * len(joinings):
            raise ValueError("a piece is joined twice")
        if not lengths and not head["refused"]:
            raise ValueError("no pieces and no reason")
        pieces = tuple(np.split(points, np.cumsum(lengths)[:-1])) if lengths else ()
        figures = str(head["way"]), int(head["faces"]), float(head["volume"]), str(head["refused"])
        return Decomposition(pieces, joinings, *figures)
    except (KeyError, TypeError, AttributeError, OverflowError, struct.error, RecursionError) as error:
        raise ValueError(str(error)) from None
