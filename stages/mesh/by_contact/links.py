"""The links as they start: a primitive or a hull for each of their colliders, or for each of their parts."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, compacted, joined, moved
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings, default_tolerance
from linkwright.stages.mesh.cut.piece import Chunk, hulled
from linkwright.stages.mesh.fit import CHEAPEST, fits
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import Piece, placed, surface_of, volume
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Primitive

LARGER = 1.1
"""How many times the volume of the hull a primitive may have."""

Placed = tuple[Hashable, Array]
"""A part, and link_from_part (4, 4)."""

_HERE: Placed = (None, np.eye(4))
_NOTHING = Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))


@dataclass(frozen=True, slots=True, eq=False)
class Touchable:
    """A link. `groups`: the surfaces of what each of its colliders by contact is made of; `fixed`: the pieces
    that stay as they are; `parts`: of each surface which part it is of, None where it is mirrored, and
    link_from_part (4, 4)."""

    link: str
    groups: tuple[tuple[Surface, ...], ...]
    fixed: tuple[Piece, ...]
    parts: tuple[tuple[Placed, ...], ...]

    def surface(self) -> Surface:
        """All that is touched of the link."""
        parts = [surface for group in self.groups for surface in group]
        return joined([*parts, *map(surface_of, self.fixed)])

    def fixed_chunks(self) -> Iterator[Chunk]:
        """The pieces that stay, as an engine takes them: of a mesh that is not convex its hull."""
        for piece in self.fixed:
            solid = convex_hull(piece.vertices) if isinstance(piece, Surface) else piece
            if solid is not None:
                yield Chunk.of(_NOTHING, solid)


def started(
    bodies: Sequence[Touchable], settings: ContactSettings, known: dict[Hashable, Primitive | None]
) -> tuple[list[list[Chunk]], dict[Chunk, Chunk]]:
    """One primitive or hull for each group, and the hull of each primitive."""
    hulls: dict[Chunk, Chunk] = {}
    chunks = []
    for body in bodies:
        made = list(body.fixed_chunks())
        for group, (surfaces, parts) in enumerate(zip(body.groups, body.parts, strict=True)):
            hull = hulled(compacted(joined(surfaces)), settings.max_vertices, group)
            if hull is None:
                continue
            primitive = _primitive(hull, settings, parts[0] if len(parts) == 1 else _HERE, known)
            made.append(_with_primitive(hull, primitive))
            if primitive is not None:
                hulls[made[-1]] = hull
        chunks.append(made)
    return chunks, hulls


def _primitive(
    hull: Chunk,
    settings: ContactSettings,
    placed_part: Placed,
    known: dict[Hashable, Primitive | None],
) -> Primitive | None:
    """The cheapest primitive that is as the hull, within the tolerance; of a part that many links have, it is
    fitted once, in the part's own frame, and `known`."""
    assert isinstance(hull.piece, Surface)
    part, link_from_part = placed_part
    if part is None or part not in known:
        own = moved(hull.piece, inverse(link_from_part))
        tolerance = default_tolerance(own.diagonal)
        near = (fit.primitive for fit in fits(own, CHEAPEST[settings.target], tolerance))
        known[part] = next((shape for shape in near if volume(shape) <= LARGER * hull.volume), None)
    found = known[part]
    return None if found is None else cast("Primitive", placed(found, link_from_part))


def _with_primitive(hull: Chunk, primitive: Primitive | None) -> Chunk:
    """The piece, with the primitive in the place of its hull where it has a primitive."""
    return hull if primitive is None else Chunk.of(hull.surface, primitive, hull.group)


def by_part(
    body: Touchable, settings: ContactSettings, known: dict[Hashable, Primitive | None] | None = None
) -> Iterator[Chunk]:
    """A hull for each part, or the primitive that is as its hull, where those that are `known` are given: so
    a foot stays round."""
    yield from body.fixed_chunks()
    for group, (surfaces, parts) in enumerate(zip(body.groups, body.parts, strict=True)):
        for surface, part in zip(surfaces, parts, strict=True):
            hull = hulled(compacted(surface), settings.max_vertices, group)
            if hull is None:
                continue
            primitive = None if known is None else _primitive(hull, settings, part, known)
            yield _with_primitive(hull, primitive)
