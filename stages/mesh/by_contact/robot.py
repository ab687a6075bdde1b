"""The colliders by contact of a whole robot, from surfaces to pieces."""

from __future__ import annotations

import hashlib
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.by_contact import meeting
from linkwright.stages.mesh.by_contact.ends import End
from linkwright.stages.mesh.by_contact.fitting import EndFitter, EndToFit, FittedEnd, end_fitter
from linkwright.stages.mesh.by_contact.links import Touchable, by_part, started
from linkwright.stages.mesh.by_contact.pair import Pair
from linkwright.stages.mesh.by_contact.poses import near_pairs, relative
from linkwright.stages.mesh.by_contact.request import POSES, ContactRequest, FalsePair
from linkwright.stages.mesh.by_contact.search import PieceSearch
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings, default_tolerance
from linkwright.stages.mesh.cut.piece import Chunk, rough
from linkwright.stages.mesh.library import MOVED
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import Piece, surface_of
from linkwright.stages.robot.contact.clearance import engine
from linkwright.stages.robot.model.robot import Array, Primitive, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.pose_batch import many_link_poses, repeated
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home

MARGIN = 0.002
"""How deep [m] colliders of two links may be in each other that are this far apart."""

NEAR = MARGIN - 2 * MOVED
"""So far apart [m] are at least, with fewer triangles, links that are `MARGIN` apart."""

AT_HOME = -2e-5
"""The same depth at `home`, where nothing may touch that is apart in CAD. Less than 0 is a gap: a file has
few digits."""

APART = 2 * MOVED
"""How far apart [m] links must be at `home`, with fewer triangles, to count as apart."""

SHARE = 0.005
"""Of the poses that make a collider, in how many it may be false: of fresh poses that is below 1 %."""

MOST_PARTS = 8
"""With as many parts a link that meets the world may begin with a piece for each."""

_SLACK = 5e-4
"""By so much [m] the hull of few corners may be deeper in another than that of all."""

_MOST_PLACES = 64 * 512
"""Links times poses: a robot of very many links gets fewer poses."""


WORTH_A_PROCESS = 2000
"""Ends of robots with fewer triangles are fitted before a second process has started."""


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """By link the pieces of each group; the pairs that were false with one hull a link, and those that are
    still; `ends` by link; `poses`: how many there were beside `home`."""

    pieces: Mapping[str, tuple[tuple[Piece, ...], ...]]
    before: tuple[FalsePair, ...]
    after: tuple[FalsePair, ...]
    ends: Mapping[str, End]
    poses: int


def solved(request: ContactRequest, bodies: Sequence[Touchable]) -> Solution:
    """The pieces of the bodies (sorted by link)."""
    triangles = sum(len(surface.triangles) for body in bodies for group in body.groups for surface in group)
    with end_fitter(1 if triangles < WORTH_A_PROCESS else None) as fitter:
        return _solved(request, bodies, fitter)


def _solved(request: ContactRequest, bodies: Sequence[Touchable], fitter: EndFitter) -> Solution:
    settings = request.jobs[0].choice.settings
    assert isinstance(settings, ContactSettings)
    surfaces = [body.surface() for body in bodies]
    primitives: dict[Hashable, Primitive | None] = {}
    chunks, hulls = started(bodies, settings, primitives)
    poses = _poses(request.robot, bodies, surfaces)
    pairs = list(_pairs(request, bodies, surfaces, poses))
    search = PieceSearch(chunks, [bool(body.groups) for body in bodies], pairs, settings.max_vertices, hulls)
    before = _false(search, bodies, poses)
    search.refine(lambda link: list(by_part(bodies[link], settings)))
    search.merge()
    numbers = _ends(request, bodies, surfaces, chunks, poses)
    ends = dict[str, End]()
    to_fit = list(_to_fit(numbers, search, bodies, surfaces, settings, primitives))
    for number, (made, end) in zip(numbers, _fitted(to_fit, fitter), strict=True):
        search.chunks[number], ends[bodies[number].link] = made, end
    pieces = {
        body.link: tuple(
            tuple(chunk.piece for chunk in made if chunk.group == group) for group in range(len(body.groups))
        )
        for body, made in zip(bodies, search.chunks, strict=True)
    }
    return Solution(pieces, before, _false(search, bodies, poses), ends, len(poses[0]) - 1)


def _to_fit(
    numbers: Sequence[int],
    search: PieceSearch,
    bodies: Sequence[Touchable],
    surfaces: Sequence[Surface],
    settings: ContactSettings,
    primitives: dict[Hashable, Primitive | None],
) -> Iterator[EndToFit]:
    """The bodies of these numbers, whose pieces are to be made fine."""
    for number in numbers:
        body = bodies[number]
        starts = [tuple(search.chunks[number])]
        if 1 < sum(map(len, body.groups)) <= MOST_PARTS:
            parts = tuple(by_part(body, settings, primitives))
            if search.no_worse(number, parts):
                starts.insert(0, parts)
        yield EndToFit(surfaces[number], tuple(starts), settings)


def _fitted(ends: Sequence[EndToFit], fitter: EndFitter) -> list[FittedEnd]:
    """Ends fitted, those that are the same, such as the fingers of a hand, once."""
    names = [_content(end.surface, end.starts) for end in ends]
    different = [number for number, name in enumerate(names) if names.index(name) == number]
    made = fitter.fitted([ends[number] for number in different])
    fitted = {names[number]: one for number, one in zip(different, made, strict=True)}
    return [fitted[name] for name in names]


def _content(surface: Surface, starts: Sequence[Sequence[Chunk]]) -> bytes:
    """The same for links that are the same to 1e-9 m."""
    found = hashlib.sha256()
    chunks = [chunk for start in starts for chunk in start]
    shapes = [surface, *(shape for chunk in chunks for shape in (chunk.surface, surface_of(chunk.piece)))]
    for shape in shapes:
        found.update(np.array([len(shape.vertices), len(shape.triangles)]).tobytes())
        found.update((shape.vertices.round(9) + 0.0).tobytes() + shape.triangles.tobytes())
    found.update(repr([[(chunk.group, type(chunk.piece)) for chunk in start] for start in starts]).encode())
    return found.digest()


def _poses(robot: Robot, bodies: Sequence[Touchable], surfaces: Sequence[Surface]) -> list[Array]:
    """root_from_link (n, 4, 4) of each body, at `home` first."""
    start = home(robot)
    placed = link_poses(robot, start)
    corners = [
        surface.vertices @ placed[body.link][:3, :3].T + placed[body.link][:3, 3]
        for body, surface in zip(bodies, surfaces, strict=True)
    ]
    low, high = (np.array([pick(points, axis=0) for points in corners]) for pick in (np.min, np.max))
    reach = float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))
    count = min(POSES, max(16, _MOST_PLACES // len(bodies)))
    drawn = sampled_poses(robot, count, reach, start)
    first = repeated(start, 1)
    every = many_link_poses(robot, {name: np.concatenate([first[name], drawn[name]]) for name in drawn})
    return [every[body.link] if drawn else placed[body.link][None] for body in bodies]


def _pairs(
    request: ContactRequest, bodies: Sequence[Touchable], surfaces: Sequence[Surface], poses: Sequence[Array]
) -> Iterator[Pair]:
    """The pairs that may be false, each with the poses in which its meshes are apart and hulls overlap."""
    if request.apart is None:
        return
    ask = engine()
    hulls = [rough(surface.vertices) for surface in surfaces]
    bounds = tuple(
        np.array([pick(surface.vertices, axis=0) for surface in surfaces]) for pick in (np.min, np.max)
    )
    place = {body.link: number for number, body in enumerate(bodies)}
    never = {
        (min(place[one], place[other]), max(place[one], place[other]))
        for one, other in request.apart
        if one in place and other in place
    }
    meshes = {}
    count = len(poses[0]) - 1
    for near in near_pairs(poses, (bounds[0], bounds[1]), 0.0, never):
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
            margin = APART if home[row] else NEAR
            if not ask.near(meshes[near.one], meshes[near.other], pose, margin):
                kept.append(row)
        if kept:
            at_home = home[kept]
            borne = np.where(at_home, AT_HOME, MARGIN)
            row = int(at_home.argmax()) if at_home.any() else -1
            yield Pair(near.one, near.other, places[kept], borne, int(SHARE * count), row)


def _false(search: PieceSearch, bodies: Sequence[Touchable], poses: Sequence[Array]) -> tuple[FalsePair, ...]:
    """The pairs that are false too often."""
    count = max(1, len(poses[0]) - 1)
    found = []
    for pair in search.pairs:
        deeper = search.deeper(pair)
        if pair.badness(deeper) > pair.allowed:
            home = pair.false_at_home(deeper)
            share = (int(np.count_nonzero(deeper)) - home) / count
            names = bodies[pair.one].link, bodies[pair.other].link
            found.append(FalsePair(*names, round(share, 4), home, round(float(deeper.max()), 6)))
    return tuple(found)


def _ends(
    request: ContactRequest,
    bodies: Sequence[Touchable],
    surfaces: Sequence[Surface],
    chunks: Sequence[Sequence[Chunk]],
    poses: Sequence[Array],
) -> list[int]:
    """Those bodies that are to be within their tolerance, by number."""
    place = {body.link: number for number, body in enumerate(bodies)}
    mine = {body.link for body, made in zip(bodies, chunks, strict=True) if body.groups and made}
    fine = request.fine
    if fine is None:
        robot = request.robot
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
            {link: default_tolerance(surfaces[place[link]].diagonal) for link in place},
        )
    return sorted(place[link] for link in mine & set(fine))
