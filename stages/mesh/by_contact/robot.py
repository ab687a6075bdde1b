"""Makes the colliders by contact of a whole robot, from surfaces to pieces."""

from __future__ import annotations

import hashlib
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.by_contact import meeting
from linkwright.stages.mesh.by_contact.ends import End
from linkwright.stages.mesh.by_contact.fitting import EndFitter, EndToFit, FittedEnd, end_fitter
from linkwright.stages.mesh.by_contact.links import Touchable, chunks_by_part, initial_chunks
from linkwright.stages.mesh.by_contact.pair import LinkPair
from linkwright.stages.mesh.by_contact.poses import near_pairs, relative
from linkwright.stages.mesh.by_contact.request import POSES, ContactRequest, FalsePair
from linkwright.stages.mesh.by_contact.search import PieceSearch
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings, default_tolerance
from linkwright.stages.mesh.cut.chunk import Chunk, engine_hull
from linkwright.stages.mesh.library import MAX_DECIMATION_MOVE
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import Piece, surface_of
from linkwright.stages.robot.contact.clearance import engine
from linkwright.stages.robot.model.robot import Array, Primitive, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.pose_batch import many_link_poses, repeated
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home

OVERLAP_MARGIN = 0.002
"""Largest depth [m] by which the colliders of two links may overlap if the links are this far apart."""

MESH_MARGIN = OVERLAP_MARGIN - 2 * MAX_DECIMATION_MOVE
"""Smallest distance [m] between the decimated meshes of links that are `OVERLAP_MARGIN` apart."""

HOME_MARGIN = -2e-5
"""Largest depth [m] at `home`, where links that are apart in CAD may not touch. It is negative, a gap, since
the numbers in files are rounded."""

HOME_MESH_MARGIN = 2 * MAX_DECIMATION_MOVE
"""Smallest distance [m] at `home` between the decimated meshes of links that count as apart."""

MAX_FALSE_SHARE = 0.005
"""Largest share of the poses in which a pair may be false; in other poses it is then below 1 %."""

MAX_PARTS = 8
"""Largest number of parts of a link that meets the world and may begin with a piece for each part."""

_HULL_SLACK = 5e-4
"""Largest length [m] by which a hull of few corners may be deeper in another hull than the full hull is."""

_MAX_LINK_POSES = 64 * 512
"""Largest product of links and poses: a robot with very many links gets fewer poses."""


MIN_TRIANGLES_FOR_PROCESS = 2000
"""Smallest number of a robot's triangles for which a second process is worth its start."""


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """The colliders by contact of a robot."""

    pieces: Mapping[str, tuple[tuple[Piece, ...], ...]]
    """Link → the pieces of each of its groups."""
    before: tuple[FalsePair, ...]
    """Pairs that were false before any piece was cut."""
    after: tuple[FalsePair, ...]
    """Pairs that are still false."""
    ends: Mapping[str, End]
    """Link that meets the world → how near its collider is to it."""
    poses: int
    """Number of poses, without `home`."""


def solve(request: ContactRequest, bodies: Sequence[Touchable]) -> Solution:
    """Makes the pieces of the bodies, which are sorted by link."""
    triangles = sum(len(surface.triangles) for body in bodies for group in body.groups for surface in group)
    with end_fitter(1 if triangles < MIN_TRIANGLES_FOR_PROCESS else None) as fitter:
        return _solve(request, bodies, fitter)


def _solve(request: ContactRequest, bodies: Sequence[Touchable], fitter: EndFitter) -> Solution:
    settings = request.jobs[0].choice.settings
    assert isinstance(settings, ContactSettings)
    surfaces = [body.surface() for body in bodies]
    primitives: dict[Hashable, Primitive | None] = {}
    chunks, hulls = initial_chunks(bodies, settings, primitives)
    poses = _poses(request.robot, bodies, surfaces)
    pairs = list(_pairs(request, bodies, surfaces, poses))
    search = PieceSearch(chunks, [bool(body.groups) for body in bodies], pairs, settings.max_vertices, hulls)
    before = _false_pairs(search, bodies, poses)
    search.refine(lambda link: list(chunks_by_part(bodies[link], settings)))
    search.merge()
    numbers = _ends(request, bodies, surfaces, chunks, poses)
    ends = dict[str, End]()
    to_fit = list(_to_fit(numbers, search, bodies, surfaces, settings, primitives))
    for number, (end_chunks, end) in zip(numbers, _fitted(to_fit, fitter), strict=True):
        search.chunks[number], ends[bodies[number].link] = end_chunks, end
    pieces = {
        body.link: tuple(
            tuple(chunk.piece for chunk in end_chunks if chunk.collider_index == group)
            for group in range(len(body.groups))
        )
        for body, end_chunks in zip(bodies, search.chunks, strict=True)
    }
    return Solution(pieces, before, _false_pairs(search, bodies, poses), ends, len(poses[0]) - 1)


def _to_fit(
    numbers: Sequence[int],
    search: PieceSearch,
    bodies: Sequence[Touchable],
    surfaces: Sequence[Surface],
    settings: ContactSettings,
    primitives: dict[Hashable, Primitive | None],
) -> Iterator[EndToFit]:
    """Yields the task of fitting for each of the bodies with these indices."""
    for number in numbers:
        body = bodies[number]
        starts = [tuple(search.chunks[number])]
        if 1 < sum(map(len, body.groups)) <= MAX_PARTS:
            parts = tuple(chunks_by_part(body, settings, primitives))
            if search.no_worse(number, parts):
                starts.insert(0, parts)
        yield EndToFit(surfaces[number], tuple(starts), settings)


def _fitted(ends: Sequence[EndToFit], fitter: EndFitter) -> list[FittedEnd]:
    """Fits ends; equal ends, such as the fingers of a hand, are fitted once."""
    digests = [_content(end.surface, end.starts) for end in ends]
    distinct = [number for number, digest in enumerate(digests) if digests.index(digest) == number]
    fitted_ends = fitter.fitted([ends[number] for number in distinct])
    end_of = {digests[number]: fit for number, fit in zip(distinct, fitted_ends, strict=True)}
    return [end_of[digest] for digest in digests]


def _content(surface: Surface, starts: Sequence[Sequence[Chunk]]) -> bytes:
    """Returns a digest that is the same for links that are equal to 1e-9 m."""
    digest = hashlib.sha256()
    chunks = [chunk for start in starts for chunk in start]
    shapes = [surface, *(shape for chunk in chunks for shape in (chunk.surface, surface_of(chunk.piece)))]
    for shape in shapes:
        digest.update(np.array([len(shape.vertices), len(shape.triangles)]).tobytes())
        digest.update((shape.vertices.round(9) + 0.0).tobytes() + shape.triangles.tobytes())
    digest.update(
        repr([[(chunk.collider_index, type(chunk.piece)) for chunk in start] for start in starts]).encode()
    )
    return digest.digest()


def _poses(robot: Robot, bodies: Sequence[Touchable], surfaces: Sequence[Surface]) -> list[Array]:
    """Returns root_from_link (n, 4, 4) of each body, at `home` first."""
    start = home(robot)
    home_poses = link_poses(robot, start)
    corners = [
        surface.vertices @ home_poses[body.link][:3, :3].T + home_poses[body.link][:3, 3]
        for body, surface in zip(bodies, surfaces, strict=True)
    ]
    low, high = (np.array([pick(points, axis=0) for points in corners]) for pick in (np.min, np.max))
    diagonal = float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))
    count = min(POSES, max(16, _MAX_LINK_POSES // len(bodies)))
    samples = sampled_poses(robot, count, diagonal, start)
    first = repeated(start, 1)
    pose_table = many_link_poses(
        robot, {name: np.concatenate([first[name], samples[name]]) for name in samples}
    )
    return [pose_table[body.link] if samples else home_poses[body.link][None] for body in bodies]


def _pairs(
    request: ContactRequest, bodies: Sequence[Touchable], surfaces: Sequence[Surface], poses: Sequence[Array]
) -> Iterator[LinkPair]:
    """Yields the pairs that may be false, with the poses in which their meshes are apart and hulls
    overlap."""
    if request.apart is None:
        return
    collision_engine = engine()
    hulls = [engine_hull(surface.vertices) for surface in surfaces]
    bounds = tuple(
        np.array([pick(surface.vertices, axis=0) for surface in surfaces]) for pick in (np.min, np.max)
    )
    index_of = {body.link: number for number, body in enumerate(bodies)}
    excluded = {
        (min(index_of[first], index_of[second]), max(index_of[first], index_of[second]))
        for first, second in request.apart
        if first in index_of and second in index_of
    }
    meshes = {}
    count = len(poses[0]) - 1
    for near_pair in near_pairs(poses, (bounds[0], bounds[1]), 0.0, excluded):
        first, second = hulls[near_pair.first_link], hulls[near_pair.second_link]
        if first is None or second is None:
            continue
        places = relative(
            poses[near_pair.first_link][near_pair.rows], poses[near_pair.second_link][near_pair.rows]
        )
        is_home = near_pair.rows == 0
        kept_rows = []
        for row, pose in enumerate(collision_engine.poses(places)):
            if collision_engine.depth(first.solid, second.solid, pose) <= (
                HOME_MARGIN if is_home[row] else OVERLAP_MARGIN - _HULL_SLACK
            ):
                continue
            for number in (near_pair.first_link, near_pair.second_link):
                if number not in meshes:
                    meshes[number] = collision_engine.mesh(
                        surfaces[number].vertices, surfaces[number].triangles
                    )
            margin = HOME_MESH_MARGIN if is_home[row] else MESH_MARGIN
            if not collision_engine.near(
                meshes[near_pair.first_link], meshes[near_pair.second_link], pose, margin
            ):
                kept_rows.append(row)
        if kept_rows:
            at_home = is_home[kept_rows]
            allowed_depths = np.where(at_home, HOME_MARGIN, OVERLAP_MARGIN)
            row = int(at_home.argmax()) if at_home.any() else -1
            yield LinkPair(
                near_pair.first_link,
                near_pair.second_link,
                places[kept_rows],
                allowed_depths,
                int(MAX_FALSE_SHARE * count),
                row,
            )


def _false_pairs(
    search: PieceSearch, bodies: Sequence[Touchable], poses: Sequence[Array]
) -> tuple[FalsePair, ...]:
    """Returns the pairs that are false too often."""
    count = max(1, len(poses[0]) - 1)
    pairs = []
    for pair in search.pairs:
        depths = search.excess_depths(pair)
        if pair.badness(depths) > pair.max_false_poses:
            is_home = pair.false_at_home(depths)
            share = (int(np.count_nonzero(depths)) - is_home) / count
            names = bodies[pair.first_link].link, bodies[pair.second_link].link
            pairs.append(FalsePair(*names, round(share, 4), is_home, round(float(depths.max()), 6)))
    return tuple(pairs)


def _ends(
    request: ContactRequest,
    bodies: Sequence[Touchable],
    surfaces: Sequence[Surface],
    chunks: Sequence[Sequence[Chunk]],
    poses: Sequence[Array],
) -> list[int]:
    """Returns the indices of the bodies that must be within their tolerance."""
    index_of = {body.link: number for number, body in enumerate(bodies)}
    by_contact = {body.link for body, pieces in zip(bodies, chunks, strict=True) if body.groups and pieces}
    fine = request.fine
    if fine is None:
        robot = request.robot
        chain_ends = meeting.ends_of_chains(robot, list(index_of))
        hulls = {
            link: hull
            for link in by_contact
            if (hull := convex_hull(np.concatenate([chunk.vertices for chunk in chunks[index_of[link]]])))
        }
        fine = meeting.with_jaws(
            robot,
            chain_ends,
            {link: surfaces[number] for link, number in index_of.items()},
            hulls,
            {link: poses[number] for link, number in index_of.items()},
            {link: default_tolerance(surfaces[index_of[link]].diagonal) for link in index_of},
        )
    return sorted(index_of[link] for link in by_contact & set(fine))
