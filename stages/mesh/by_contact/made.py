"""Colliders by contact of the links that ask for them, kept by what they depend on."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import struct
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import orjson

from stages.mesh import collision
from stages.mesh.collision import Collision
from stages.mesh.pieces import Piece, surface_of
from stages.mesh.surface import Surface
from stages.robot.adjacency import Pair
from stages.robot.geometry import Measures
from stages.robot.globs import listed
from stages.robot.model import Robot
from stages.robot.plural import count

if TYPE_CHECKING:
    from stages.mesh import Memo
    from stages.mesh.by_contact.robot import End, Placed, Solution, Wrong
    from stages.mesh.collide import ColliderJob
    from stages.mesh.library import MeshLibrary

POSES = 512
"""Seeded poses that make colliders: by fewer harmless pairs look bad, by 64 of them 5 to 9 %."""


@dataclass(frozen=True, slots=True)
class StillFalse:
    """Two links whose colliders overlap where the links are apart, in too many of the poses, or at `home`.

    `share`: of the poses; `depth` [m]: how much deeper than is borne they are then.
    """

    one: str
    other: str
    share: float
    home: bool
    depth: float


def by_contact(
    robot: Robot,
    jobs: Sequence[ColliderJob],
    fixed: Mapping[str, Sequence[Piece]],
    apart: Collection[Pair] | None,
    fine: Collection[str] | None,
    library: MeshLibrary,
    memo: Memo,
) -> tuple[list[Collision], list[StillFalse]]:
    """The collider of each job, and the pairs of links that are false for all that.

    `fixed`: by link the pieces that stay as they are, in its frame; `apart`: pairs of links that do not
    collide, None where no two do; `fine`: the links that are to be within their tolerance, None for those
    that meet the world.
    """
    from stages.mesh.motion_digest import motion_digest

    if not jobs:
        return [], []

    def make() -> bytes:
        return _encoded(*_made(robot, jobs, fixed, apart, fine, library))

    key = {
        "jobs": [[job.link, job.key()] for job in jobs],
        "fixed": {link: collision.digest(pieces) for link, pieces in sorted(fixed.items())},
        "apart": None if apart is None else sorted(apart),
        "fine": sorted([one.name, one.link] for one in robot.frames) if fine is None else [sorted(fine)],
        "motion": motion_digest(robot),
        "poses": POSES,
        "engine": _engine(),
    }
    return _decoded(memo("mesh.by_contact", key, make))


def _engine() -> str:
    name = "coal" if importlib.util.find_spec("coal") else "python-fcl"
    return f"{name} {importlib.metadata.version(name)}"


def _made(
    robot: Robot,
    jobs: Sequence[ColliderJob],
    fixed: Mapping[str, Sequence[Piece]],
    apart: Collection[Pair] | None,
    fine: Collection[str] | None,
    library: MeshLibrary,
) -> tuple[list[Collision], list[StillFalse]]:
    from stages.mesh.by_contact.robot import Touchable, found

    of_link: dict[str, list[int]] = {link: [] for link in fixed}
    for number, job in enumerate(jobs):
        of_link.setdefault(job.link, []).append(number)
    solids = [_finite(job, library) for job in jobs]
    surfaces = [[surface for surface, _ in every] for every in solids]
    bodies, groups = list[Touchable](), dict[int, tuple[str, int]]()
    for link, numbers in sorted(of_link.items()):
        solid = [number for number in numbers if surfaces[number]]
        groups |= {number: (link, group) for group, number in enumerate(solid)}
        body = Touchable(
            link,
            tuple(tuple(surfaces[number]) for number in solid),
            tuple(fixed.get(link, ())),
            tuple(tuple(part for _, part in solids[number]) for number in solid),
        )
        if body.groups or body.fixed:
            bodies.append(body)
    result = found(robot, bodies, apart, fine, jobs[0].choice.settings, POSES)
    every = []
    for number, job in enumerate(jobs):
        faces = sum(len(surface.triangles) for surface in surfaces[number])
        link, group = groups.get(number, (job.link, -1))
        pieces = result.pieces[link][group] if group >= 0 else ()
        every.append(_collision(link, pieces, faces, surfaces[number], result))
    return every, [
        StillFalse(one.one, one.other, round(one.count / max(1, one.of), 4), one.home, round(one.depth, 6))
        for one in result.after
    ]


def _finite(job: ColliderJob, library: MeshLibrary) -> list[tuple[Surface, Placed]]:
    """The surfaces of a job, in its link's frame, and which part each is of."""
    found = list[tuple[Surface, "Placed"]]()
    for use, surface in zip(job.uses, job.surfaces(library), strict=True):
        if len(surface.triangles) and bool(np.isfinite(surface.vertices[surface.triangles]).all()):
            mirrored = np.linalg.det(use.link_from_part[:3, :3]) < 0
            found.append((surface, (None if mirrored else use.mesh, use.link_from_part)))
    return found


def _collision(
    link: str, pieces: Sequence[Piece], faces: int, surfaces: Sequence[Surface], result: Solution
) -> Collision:
    if not pieces:
        return Collision(note="it is flat" if faces else "it has no mesh")
    kind = "hull" if isinstance(pieces[0], Surface) else pieces[0].kind
    made = Collision(tuple(pieces), faces, rung="pieces" if len(pieces) > 1 else kind)
    end = result.ends.get(link)
    if end is not None:
        made = replace(made, measures=_measures(pieces, surfaces, end), tolerance=round(end.tolerance, 9))
        made = replace(made, meets=end.p95 <= end.tolerance)
    return replace(made, reason="; ".join(_reasons(link, len(pieces), result, end)))


def _measures(pieces: Sequence[Piece], surfaces: Sequence[Surface], end: End) -> Measures:
    """What was measured of the outer surface of an end; its triangles are all in its pieces."""
    closed = all(surface.closed() for surface in surfaces)
    own = sum(abs(surface.volume()) for surface in surfaces)
    extra = sum(surface_of(piece).volume() for piece in pieces) / own - 1 if closed and own > 0 else None
    rounded = None if extra is None else round(extra, 6)
    return Measures(rounded, 0.0, "sampling", round(end.p95, 7), round(end.most, 7), 0.0, 0.0)


def _reasons(link: str, pieces: int, result: Solution, end: End | None) -> Iterator[str]:
    """Why a link has so many pieces, in words."""
    cut_for = [_other(one, link) for one in result.before if link in (one.one, one.other)]
    left = [_other(one, link) for one in result.after if link in (one.one, one.other)]
    if cut_for and pieces > 1:
        yield f"{count(pieces, 'piece')} against {listed(cut_for)}"
    elif not left:
        yield f"false in at most 0.5 % of {result.poses} poses" if result.poses else "nothing moves"
    if left:
        yield f"still false against {listed(left)}"
    if end is not None:
        yield f"meets the world: {1e3 * end.p95:.2g} mm out of the link, of {1e3 * end.tolerance:.2g} mm"


def _other(pair: Wrong, link: str) -> str:
    return pair.other if pair.one == link else pair.one


def _encoded(made: Sequence[Collision], false: Sequence[StillFalse]) -> bytes:
    bodies = [collision.encode(one) for one in made]
    header = orjson.dumps({"lengths": [len(one) for one in bodies], "false": [_plain(one) for one in false]})
    return struct.pack("<Q", len(header)) + header + b"".join(bodies)


def _plain(one: StillFalse) -> list[Any]:
    return [one.one, one.other, one.share, one.home, one.depth]


def _decoded(data: bytes) -> tuple[list[Collision], list[StillFalse]]:
    (length,) = struct.unpack_from("<Q", data)
    header, at, made = orjson.loads(data[8 : 8 + length]), 8 + length, []
    for size in header["lengths"]:
        made.append(collision.decode(data[at : at + size]))
        at += size
    return made, [StillFalse(*one) for one in header["false"]]
