"""The colliders by contact of a whole robot, from surfaces to pieces."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from stages.mesh.by_contact import meeting
from stages.mesh.by_contact.ends import fitted
from stages.mesh.by_contact.outside import Outside
from stages.mesh.by_contact.pair import Pair
from stages.mesh.by_contact.piece import Chunk, hulled, rough
from stages.mesh.by_contact.poses import near_pairs, relative
from stages.mesh.by_contact.search import PieceSearch
from stages.mesh.collider_settings import ColliderSettings, default_tolerance
from stages.mesh.convex_hull import convex_hull
from stages.mesh.fit import fits
from stages.mesh.pieces import Piece, placed, surface_of, volume
from stages.mesh.surface import Surface, joined, moved
from stages.robot.adjacency import Pair as Names
from stages.robot.clearance import engine
from stages.robot.model import Array, Primitive, Robot
from stages.robot.poses import inverse

MARGIN = 0.002
"""How deep [m] colliders of two links may be in each other that are this far apart."""

AT_HOME = -2e-5
"""The same depth at `home`, where nothing may touch that is apart in CAD. Less than 0 is a gap: a file has
few digits."""

APART = 1e-4
"""How far apart [m] links must be at `home` to count as apart."""

SHARE = 0.005
"""Of the poses that make a collider, in how many it may be false: of fresh poses that is below 1 %."""

LARGER = 1.1
"""How many times the volume of the hull a primitive may have."""

MOST_PARTS = 8
"""With as many parts a link that meets the world may begin with a piece for each."""

_SLACK = 5e-4
"""By so much [m] the hull of few corners may be deeper in another than that of all."""

_MOST_PLACES = 64 * 512
"""Links times poses: a robot of very many links gets fewer poses."""


Placed = tuple[Hashable, Array]
"""A part, and link_from_part (4, 4)."""

_HERE: Placed = (None, np.eye(4))


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


@dataclass(frozen=True, slots=True)
class Wrong:
    """Two links that are false in `count` of `of` poses, or at `home`; `depth` [m]: how much deeper than is
    borne their colliders are then."""

    one: str
    other: str
    count: int
    of: int
    home: bool
    depth: float


@dataclass(frozen=True, slots=True, eq=False)
class End:
    """How far [m] the collider of a link that meets the world stands out, 95 % of it and at most."""

    tolerance: float
    p95: float
    most: float


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """By link the pieces of each group; the pairs that were false with one hull a link, and those that are
    still; `ends` by link."""

    pieces: Mapping[str, tuple[tuple[Piece, ...], ...]]
    before: tuple[Wrong, ...]
    after: tuple[Wrong, ...]
    ends: Mapping[str, End]
    poses: int


def found(
    robot: Robot,
    bodies: Sequence[Touchable],
    apart: Collection[Names] | None,
    fine: Collection[str] | None,
    settings: ColliderSettings,
    most_poses: int,
) -> Solution:
    """The pieces of the bodies (sorted by link). `apart`: pairs of links that do not collide, None where none
    does; `fine`: the links that are to be within their tolerance, None for those that meet the world."""
    surfaces = [body.surface() for body in bodies]
    known: dict[Hashable, Primitive | None] = {}
    chunks, hulls = _started(bodies, settings, known)
    poses = _poses(robot, bodies, surfaces, most_poses)
    pairs = [] if apart is None else list(_pairs(bodies, surfaces, poses, apart))
    search = PieceSearch(chunks, [bool(body.groups) for body in bodies], pairs, settings.max_vertices, hulls)
    before = _wrong(search, bodies, poses)
    search.refine(lambda link: list(_by_part(bodies[link], settings)))
    search.merge()
    ends = {}
    for number in _ends(robot, bodies, surfaces, chunks, poses, fine):
        body, tolerance = bodies[number], default_tolerance(_diagonal(surfaces[number]))
        outside = Outside.of(surfaces[number], tolerance)
        starts = [search.chunks[number]]
        if 1 < sum(map(len, body.groups)) <= MOST_PARTS:
            parts = list(_by_part(body, settings, known))
            if search.no_worse(number, parts):
                starts.insert(0, parts)
        search.chunks[number] = fitted(starts, outside, tolerance, settings.max_vertices)
        out = outside.standing_out([outside.sampled(chunk.piece) for chunk in search.chunks[number]])
        ends[body.link] = End(tolerance, out.p95, out.most)
    pieces = {
        body.link: tuple(
            tuple(chunk.piece for chunk in made if chunk.group == group) for group in range(len(body.groups))
        )
        for body, made in zip(bodies, search.chunks, strict=True)
    }
    return Solution(pieces, before, _wrong(search, bodies, poses), ends, len(poses[0]) - 1)


def _started(
    bodies: Sequence[Touchable], settings: ColliderSettings, known: dict[Hashable, Primitive | None]
) -> tuple[list[list[Chunk]], dict[Chunk, Chunk]]:
    """One primitive or hull for each group, and the hull of each primitive."""
    hulls: dict[Chunk, Chunk] = {}
    chunks = []
    for body in bodies:
        made = [Chunk.of(np.zeros((0, 3, 3)), piece) for piece in body.fixed]
        for group, (surfaces, parts) in enumerate(zip(body.groups, body.parts, strict=True)):
            hull = hulled(joined(surfaces).corners, settings.max_vertices, group)
            if hull is None:
                continue
            primitive = _primitive(hull, settings, parts[0] if len(parts) == 1 else _HERE, known)
            made.append(hull if primitive is None else Chunk.of(hull.soup, primitive, group))
            if primitive is not None:
                hulls[made[-1]] = hull
        chunks.append(made)
    return chunks, hulls


def _primitive(
    hull: Chunk,
    settings: ColliderSettings,
    placed_part: Placed,
    known: dict[Hashable, Primitive | None],
) -> Primitive | None:
    """The cheapest primitive that is as the hull, within the tolerance; of a part that many links have, it is
    fitted once, in the part's own frame, and `known`."""
    assert isinstance(hull.piece, Surface)
    part, link_from_part = placed_part
    if part is None or part not in known:
        own = moved(hull.piece, inverse(link_from_part))
        tolerance = default_tolerance(_diagonal(own))
        near = (one.primitive for one in fits(own, settings.target) if one.error <= tolerance)
        known[part] = next((one for one in near if volume(one) <= LARGER * hull.volume), None)
    found = known[part]
    return None if found is None else cast("Primitive", placed(found, link_from_part))


def _by_part(
    body: Touchable, settings: ColliderSettings, known: dict[Hashable, Primitive | None] | None = None
) -> Iterator[Chunk]:
    """A hull for each part, or the primitive that is as its hull, where those that are `known` are given: so
    a foot stays round."""
    for piece in body.fixed:
        yield Chunk.of(np.zeros((0, 3, 3)), piece)
    for group, (surfaces, parts) in enumerate(zip(body.groups, body.parts, strict=True)):
        for surface, part in zip(surfaces, parts, strict=True):
            hull = hulled(surface.corners, settings.max_vertices, group)
            if hull is None:
                continue
            primitive = None if known is None else _primitive(hull, settings, part, known)
            yield hull if primitive is None else Chunk.of(hull.soup, primitive, group)


def _poses(robot: Robot, bodies: Sequence[Touchable], surfaces: Sequence[Surface], most: int) -> list[Array]:
    """root_from_link (n, 4, 4) of each body, at `home` first."""
    from stages.robot.kinematics import link_poses
    from stages.robot.pose_batch import many_link_poses, repeated
    from stages.robot.pose_samples import sampled_poses
    from stages.robot.start_pose import home

    start = home(robot)
    placed = link_poses(robot, start)
    corners = [
        surface.vertices @ placed[body.link][:3, :3].T + placed[body.link][:3, 3]
        for body, surface in zip(bodies, surfaces, strict=True)
    ]
    low, high = (np.array([pick(points, axis=0) for points in corners]) for pick in (np.min, np.max))
    reach = float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))
    count = min(most, max(16, _MOST_PLACES // len(bodies)))
    drawn = sampled_poses(robot, count, reach, start)
    first = repeated(start, 1)
    every = many_link_poses(robot, {name: np.concatenate([first[name], drawn[name]]) for name in drawn})
    here = link_poses(robot, start)
    return [every[body.link] if drawn else here[body.link][None] for body in bodies]


def _pairs(
    bodies: Sequence[Touchable], surfaces: Sequence[Surface], poses: Sequence[Array], apart: Collection[Names]
) -> Iterator[Pair]:
    """The pairs that may be false, each with the poses in which its meshes are apart and hulls overlap."""
    ask = engine()
    hulls = [rough(surface.vertices) for surface in surfaces]
    bounds = tuple(
        np.array([pick(surface.vertices, axis=0) for surface in surfaces]) for pick in (np.min, np.max)
    )
    place = {body.link: number for number, body in enumerate(bodies)}
    known = [sorted((place[one], place[other])) for one, other in apart if one in place and other in place]
    meshes = {}
    count = len(poses[0]) - 1
    for near in near_pairs(poses, (bounds[0], bounds[1]), 0.0, {(a, b) for a, b in known}):
        one, other = hulls[near.one], hulls[near.other]
        if one is None or other is None:
            continue
        places = relative(poses[near.one][near.rows], poses[near.other][near.rows])
        home = near.rows == 0
        kept = []
        for row, pose in enumerate(ask.poses(places)):
            if ask.depth(one[0], other[0], pose) <= (AT_HOME if home[row] else MARGIN - _SLACK):
                continue
            for number in (near.one, near.other):
                if number not in meshes:
                    meshes[number] = ask.mesh(surfaces[number].vertices, surfaces[number].triangles)
            margin = APART if home[row] else MARGIN
            if not ask.near(meshes[near.one], meshes[near.other], pose, margin):
                kept.append(row)
        if kept:
            at_home = home[kept]
            borne = np.where(at_home, AT_HOME, MARGIN)
            row = int(at_home.argmax()) if at_home.any() else -1
            yield Pair(near.one, near.other, places[kept], borne, int(SHARE * count), row)


def _wrong(search: PieceSearch, bodies: Sequence[Touchable], poses: Sequence[Array]) -> tuple[Wrong, ...]:
    result = []
    for pair in search.pairs:
        deeper = search.deeper(pair)
        if pair.count(deeper) > pair.allowed:
            home = pair.home >= 0 and deeper[pair.home] > 0
            count = int(np.count_nonzero(deeper)) - int(home)
            names = bodies[pair.one].link, bodies[pair.other].link
            result.append(Wrong(*names, count, len(poses[0]) - 1, bool(home), float(deeper.max())))
    return tuple(result)


def _ends(
    robot: Robot,
    bodies: Sequence[Touchable],
    surfaces: Sequence[Surface],
    chunks: Sequence[Sequence[Chunk]],
    poses: Sequence[Array],
    fine: Collection[str] | None,
) -> list[int]:
    """Those bodies that are to be within their tolerance, by number."""
    place = {body.link: number for number, body in enumerate(bodies)}
    mine = {body.link for body, made in zip(bodies, chunks, strict=True) if body.groups and made}
    if fine is None:
        every = meeting.ends_of_chains(robot, list(place))
        hulls = {
            link: hull
            for link in mine
            if (hull := convex_hull(np.concatenate([one.corners for one in chunks[place[link]]])))
        }
        fine = meeting.with_jaws(
            robot,
            every,
            {link: surfaces[number] for link, number in place.items()},
            hulls,
            {link: poses[number] for link, number in place.items()},
            {link: default_tolerance(_diagonal(surfaces[place[link]])) for link in place},
        )
    return sorted(place[link] for link in mine & set(fine))


def _diagonal(surface: Surface) -> float:
    return float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
