"""Makes colliders by contact, caches them by everything on which they depend, and reports pairs of links
whose colliders still touch where the links do not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import orjson

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.by_contact.links import Touchable
from linkwright.stages.mesh.by_contact.request import ContactRequest, FalsePair
from linkwright.stages.mesh.by_contact.robot import solve
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.surfaces.pieces import Piece
from linkwright.stages.robot import codec
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.text.globs import name_list, yaml_key
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo
    from linkwright.stages.mesh.by_contact.ends import End
    from linkwright.stages.mesh.by_contact.links import Placed
    from linkwright.stages.mesh.by_contact.robot import Solution
    from linkwright.stages.mesh.collide.make import ColliderJob
    from linkwright.stages.mesh.library import MeshLibrary


ContactColliders = tuple[tuple[Collision, ...], tuple[FalsePair, ...]]
"""The collider of each job, and the pairs of links whose colliders still touch falsely."""


def by_contact(request: ContactRequest, library: MeshLibrary, memo: Memo) -> ContactColliders:
    """Returns colliders by contact, from the cache if nothing has changed on which they depend."""
    if not request.jobs:
        return (), ()
    data = memo(
        "mesh.by_contact", request.key(), lambda: orjson.dumps(codec.plain_data(_make(request, library)))
    )
    return codec.typed(ContactColliders, orjson.loads(data))  # type: ignore[no-any-return]


def _make(request: ContactRequest, library: MeshLibrary) -> ContactColliders:
    jobs_of_link: dict[str, list[int]] = {link: [] for link in request.fixed}
    for number, job in enumerate(request.jobs):
        jobs_of_link.setdefault(job.link, []).append(number)
    solids = [_finite_surfaces(job, library) for job in request.jobs]
    surfaces = [[surface for surface, _ in job_solids] for job_solids in solids]
    bodies, groups = list[Touchable](), dict[int, tuple[str, int]]()
    for link, numbers in sorted(jobs_of_link.items()):
        numbers_with_surface = [number for number in numbers if surfaces[number]]
        groups |= {number: (link, group) for group, number in enumerate(numbers_with_surface)}
        body = Touchable(
            link,
            tuple(tuple(surfaces[number]) for number in numbers_with_surface),
            tuple(request.fixed.get(link, ())),
            tuple(tuple(part for _, part in solids[number]) for number in numbers_with_surface),
        )
        if body.groups or body.fixed:
            bodies.append(body)
    solution = solve(request, bodies)
    collisions = []
    for number, job in enumerate(request.jobs):
        faces = sum(len(surface.triangles) for surface in surfaces[number])
        link, group = groups.get(number, (job.link, -1))
        pieces = solution.pieces[link][group] if group >= 0 else ()
        collisions.append(_collision(link, pieces, faces, solution))
    return tuple(collisions), solution.after


def _finite_surfaces(job: ColliderJob, library: MeshLibrary) -> list[tuple[Surface, Placed]]:
    """Returns the finite surfaces of a job, in its link's frame, each with its part."""
    placed_surfaces = list[tuple[Surface, "Placed"]]()
    for placed_mesh, surface in zip(job.placed_meshes, job.surfaces(library), strict=True):
        if len(surface.triangles) and bool(np.isfinite(surface.vertices[surface.triangles]).all()):
            mirrored = np.linalg.det(placed_mesh.link_from_part[:3, :3]) < 0
            placed_surfaces.append(
                (surface, (None if mirrored else placed_mesh.mesh, placed_mesh.link_from_part))
            )
    return placed_surfaces


def _collision(link: str, pieces: Sequence[Piece], faces: int, solution: Solution) -> Collision:
    if not pieces:
        return Collision(note="it is flat" if faces else "it has no mesh")
    kind = "hull" if isinstance(pieces[0], Surface) else pieces[0].kind
    collision = Collision(tuple(pieces), faces, rung="pieces" if len(pieces) > 1 else kind)
    end = solution.ends.get(link)
    if end is not None:
        collision = replace(
            collision, measures=end.measures, tolerance=round(end.tolerance, 9), meets=end.meets
        )
    return replace(collision, reason="; ".join(_reasons(link, len(pieces), solution, end)))


def _reasons(link: str, pieces: int, solution: Solution, end: End | None) -> Iterator[str]:
    """Yields in words why a link has this number of pieces."""
    cut_for = [pair.beside(link) for pair in solution.before if pair.has(link)]
    still_false = [pair.beside(link) for pair in solution.after if pair.has(link)]
    if cut_for and pieces > 1:
        yield f"{count(pieces, 'piece')} against {name_list(cut_for)}"
    elif not still_false:
        # 0.5 %: `MAX_FALSE_SHARE`
        yield f"false in at most 0.5 % of {solution.poses} poses" if solution.poses else "nothing moves"
    if still_false:
        yield f"still false against {name_list(still_false)}"
    if end is not None:
        yield f"meets the world: {1e3 * end.p95:.2g} mm out of the link, of {1e3 * end.tolerance:.2g} mm"


def false_contact_reports(pairs: Sequence[FalsePair]) -> Iterator[Diagnostic]:
    """Yields W-FALSE-CONTACT for links of false pairs; each pair is reported once."""
    # A pair is listed with a link that already has other pairs, so that few links are reported.
    by_link: dict[str, list[FalsePair]] = {}
    for pair in pairs:
        by_link.setdefault(
            pair.one if pair.one in by_link or pair.other not in by_link else pair.other, []
        ).append(pair)
    for link, link_pairs in by_link.items():
        descriptions = "; ".join(_description(link, pair) for pair in link_pairs)
        lines = ", ".join(f"[{yaml_key(pair.one)}, {yaml_key(pair.other)}]" for pair in link_pairs)
        yield Diagnostic(
            "W-FALSE-CONTACT",
            f"the collider of {link} touches where the link does not: {descriptions}",
            link,
            f"to let them pass through each other: `contact: {{exclude: [{lines}]}}`; or a collider by hand "
            "in mesh.colliders",
        )


def _description(link: str, pair: FalsePair) -> str:
    where = "at home" if pair.home else f"in {100 * pair.share:.2g} % of poses"
    return f"{pair.beside(link)}, {where}, by up to {1e3 * pair.depth:.2g} mm"
