"""Surfaces and decompositions as bytes: what goes to the guest, comes from it, and is cached."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stages.mesh.surface import Points, Surface, Triangles

_LENGTH = struct.Struct("<Q")


@dataclass(frozen=True, slots=True, eq=False)
class Decomposition:
    """A part as convex pieces: the corners (n, 3) of each [m]. `refused`: why there are none, where that
    follows from the mesh itself."""

    pieces: tuple[Points, ...]
    refused: str = ""


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
    return pack({"refused": made.refused}, [piece.astype("<f8") for piece in made.pieces])


def read(data: bytes) -> Decomposition:
    """The decomposition that `write` wrote; ValueError where these bytes are none."""
    try:
        head, body = _parts(data)
        lengths = [int(length) for length in head["lengths"]]
        points = np.frombuffer(body, "<f8").reshape(-1, 3)
        if min(lengths, default=0) < 0 or sum(lengths) != len(points) or not np.isfinite(points).all():
            raise ValueError("other lengths, or numbers that are none")
        if not lengths and not head["refused"]:
            raise ValueError("no pieces and no reason")
        pieces = tuple(np.split(points, np.cumsum(lengths)[:-1])) if lengths else ()
        return Decomposition(pieces, str(head["refused"]))
    except (KeyError, TypeError, AttributeError, OverflowError, struct.error, RecursionError) as error:
        raise ValueError(str(error)) from None
