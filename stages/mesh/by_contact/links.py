"""Makes the first pieces of links: a primitive or a hull for each of their colliders, or for each part."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from linkwright.stages.formats.meshes.surface import (
    Surface,
    drop_unused_points,
    join_surfaces,
    transform_surface,
)
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings, default_tolerance
from linkwright.stages.mesh.cut.chunk import Chunk, hull_chunk
from linkwright.stages.mesh.fit import allowed_kinds, fits
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import Piece, placed, surface_of, volume
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Primitive

MAX_VOLUME_RATIO = 1.1
"""Largest ratio between the volumes of a primitive and of the hull that it replaces."""

Placed = tuple[Hashable, Array]
"""A part, None for an unknown or mirrored one, and link_from_part (4, 4)."""

_NO_PART: Placed = (None, np.eye(4))
"""Used instead of a part for a hull around several parts."""

_EMPTY = Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))


@dataclass(frozen=True, slots=True, eq=False)
class Touchable:
    """A link with colliders."""

    link: str
    """Name of the link."""
    groups: tuple[tuple[Surface, ...], ...]
    """Surfaces from which each of the link's colliders by contact is made."""
    fixed: tuple[Piece, ...]
    """Pieces of the link's other colliders, which stay as they are."""
    parts: tuple[tuple[Placed, ...], ...]
    """Part and pose of each surface of `groups`."""

    def surface(self) -> Surface:
        """Returns all surfaces of the link that may touch another link, as one surface."""
        parts = [surface for group in self.groups for surface in group]
        return join_surfaces([*parts, *map(surface_of, self.fixed)])

    def fixed_chunks(self) -> Iterator[Chunk]:
        """Yields the pieces that stay, as an engine takes them: a mesh as its hull."""
        for piece in self.fixed:
            solid = convex_hull(piece.vertices) if isinstance(piece, Surface) else piece
            if solid is not None:
                yield Chunk.of(_EMPTY, solid)


def initial_chunks(
    bodies: Sequence[Touchable], settings: ContactSettings, primitives: dict[Hashable, Primitive | None]
) -> tuple[list[list[Chunk]], dict[Chunk, Chunk]]:
    """Makes one primitive or hull for each group; also returns the hull of each primitive."""
    hulls: dict[Chunk, Chunk] = {}
    chunks = []
    for body in bodies:
        pieces = list(body.fixed_chunks())
        for group, (surfaces, parts) in enumerate(zip(body.groups, body.parts, strict=True)):
            hull = hull_chunk(drop_unused_points(join_surfaces(surfaces)), settings.max_vertices, group)
            if hull is None:
                continue
            primitive = _primitive(hull, settings, parts[0] if len(parts) == 1 else _NO_PART, primitives)
            pieces.append(_with_primitive(hull, primitive))
            if primitive is not None:
                hulls[pieces[-1]] = hull
        chunks.append(pieces)
    return chunks, hulls


def _primitive(
    hull: Chunk,
    settings: ContactSettings,
    placed_part: Placed,
    primitives: dict[Hashable, Primitive | None],
) -> Primitive | None:
    """Returns the cheapest primitive that equals the hull within the tolerance. For a part that many links
    have, it is fitted once, in the part's frame, and kept in `primitives`."""
    assert isinstance(hull.piece, Surface)
    part, link_from_part = placed_part
    if part is None or part not in primitives:
        local_hull = transform_surface(hull.piece, inverse(link_from_part))
        tolerance = default_tolerance(local_hull.diagonal)
        candidates = (fit.primitive for fit in fits(local_hull, allowed_kinds(settings.limits), tolerance))
        primitives[part] = next(
            (shape for shape in candidates if volume(shape) <= MAX_VOLUME_RATIO * hull.volume), None
        )
    primitive = primitives[part]
    return None if primitive is None else cast("Primitive", placed(primitive, link_from_part))


def _with_primitive(hull: Chunk, primitive: Primitive | None) -> Chunk:
    """Returns the piece with the primitive instead of its hull, if there is a primitive."""
    return hull if primitive is None else Chunk.of(hull.surface, primitive, hull.collider_index)


def chunks_by_part(
    body: Touchable, settings: ContactSettings, primitives: dict[Hashable, Primitive | None] | None = None
) -> Iterator[Chunk]:
    """Yields a hull for each part; with `primitives`, a primitive that equals the hull, if there is one, so
    that a foot stays round."""
    yield from body.fixed_chunks()
    for group, (surfaces, parts) in enumerate(zip(body.groups, body.parts, strict=True)):
        for surface, part in zip(surfaces, parts, strict=True):
            hull = hull_chunk(drop_unused_points(surface), settings.max_vertices, group)
            if hull is None:
                continue
            primitive = None if primitives is None else _primitive(hull, settings, part, primitives)
            yield _with_primitive(hull, primitive)
