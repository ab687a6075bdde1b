"""Colliders by contact of the links that ask for them, kept by what they depend on, and what is reported of
them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import orjson

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.by_contact.links import Touchable
from linkwright.stages.mesh.by_contact.request import ContactRequest, FalsePair
from linkwright.stages.mesh.by_contact.robot import solved
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.surfaces.pieces import Piece
from linkwright.stages.robot import codec
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.text.globs import as_key, listed
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo
    from linkwright.stages.mesh.by_contact.ends import End
    from linkwright.stages.mesh.by_contact.links import Placed
    from linkwright.stages.mesh.by_contact.robot import Solution
    from linkwright.stages.mesh.collide.make import ColliderJob
    from linkwright.stages.mesh.library import MeshLibrary


Made = tuple[tuple[Collision, ...], tuple[FalsePair, ...]]
"""The collider of each job, and the pairs of links that are false for all that."""


def by_contact(request: ContactRequest, library: MeshLibrary, memo: Memo) -> Made:
    """Colliders by contact, kept by what they depend on."""
    if not request.jobs:
        return (), ()
    made = memo("mesh.by_contact", request.key(), lambda: orjson.dumps(codec.plain(_made(request, library))))
    return codec.typed(Made, orjson.loads(made))  # type: ignore[no-any-return]


def _made(request: ContactRequest, library: MeshLibrary) -> Made:
    of_link: dict[str, list[int]] = {link: [] for link in request.fixed}
    for number, job in enumerate(request.jobs):
        of_link.setdefault(job.link, []).append(number)
    solids = [_finite(job, library) for job in request.jobs]
    surfaces = [[surface for surface, _ in every] for every in solids]
    bodies, groups = list[Touchable](), dict[int, tuple[str, int]]()
    for link, numbers in sorted(of_link.items()):
        solid = [number for number in numbers if surfaces[number]]
        groups |= {number: (link, group) for group, number in enumerate(solid)}
        body = Touchable(
            link,
            tuple(tuple(surfaces[number]) for number in solid),
            tuple(request.fixed.get(link, ())),
            tuple(tuple(part for _, part in solids[number]) for number in solid),
        )
        if body.groups or body.fixed:
            bodies.append(body)
    solution = solved(request, bodies)
    every = []
    for number, job in enumerate(request.jobs):
        faces = sum(len(surface.triangles) for surface in surfaces[number])
        link, group = groups.get(number, (job.link, -1))
        pieces = solution.pieces[link][group] if group >= 0 else ()
        every.append(_collision(link, pieces, faces, solution))
    return tuple(every), solution.after


def _finite(job: ColliderJob, library: MeshLibrary) -> list[tuple[Surface, Placed]]:
    """The surfaces of a job, in its link's frame, and which part each is of."""
    found = list[tuple[Surface, "Placed"]]()
    for use, surface in zip(job.uses, job.surfaces(library), strict=True):
        if len(surface.triangles) and bool(np.isfinite(surface.vertices[surface.triangles]).all()):
            mirrored = np.linalg.det(use.link_from_part[:3, :3]) < 0
            found.append((surface, (None if mirrored else use.mesh, use.link_from_part)))
    return found


def _collision(link: str, pieces: Sequence[Piece], faces: int, solution: Solution) -> Collision:
    if not pieces:
        return Collision(note="it is flat" if faces else "it has no mesh")
    kind = "hull" if isinstance(pieces[0], Surface) else pieces[0].kind
    made = Collision(tuple(pieces), faces, rung="pieces" if len(pieces) > 1 else kind)
    end = solution.ends.get(link)
    if end is not None:
        made = replace(made, measures=end.measures, tolerance=round(end.tolerance, 9), meets=end.meets)
    return replace(made, reason="; ".join(_reasons(link, len(pieces), solution, end)))


def _reasons(link: str, pieces: int, solution: Solution, end: End | None) -> Iterator[str]:
    """Why a link has so many pieces, in words."""
    cut_for = [pair.beside(link) for pair in solution.before if pair.has(link)]
    left = [pair.beside(link) for pair in solution.after if pair.has(link)]
    if cut_for and pieces > 1:
        yield f"{count(pieces, 'piece')} against {listed(cut_for)}"
    elif not left:
        yield f"false in at most 0.5 % of {solution.poses} poses" if solution.poses else "nothing moves"
    if left:
        yield f"still false against {listed(left)}"
    if end is not None:
        yield f"meets the world: {1e3 * end.p95:.2g} mm out of the link, of {1e3 * end.tolerance:.2g} mm"


def false_contacts(pairs: Sequence[FalsePair]) -> Iterator[Diagnostic]:
    """W-FALSE-CONTACT for each link of such pairs, with the pairs that no link before it named."""
    told: dict[str, list[FalsePair]] = {}
    for pair in pairs:
        told.setdefault(pair.one if pair.one in told or pair.other not in told else pair.other, []).append(
            pair
        )
    for link, own in told.items():
        said = "; ".join(_said(link, pair) for pair in own)
        lines = ", ".join(f"[{as_key(pair.one)}, {as_key(pair.other)}]" for pair in own)
        yield Diagnostic(
            "W-FALSE-CONTACT",
            f"the collider of {link} touches where the link does not: {said}",
            link,
            f"to let them pass through each other: `contact: {{exclude: [{lines}]}}`; or a collider by hand "
            "in mesh.colliders",
        )


def _said(link: str, pair: FalsePair) -> str:
    where = "at home" if pair.home else f"in {100 * pair.share:.2g} % of poses"
    return f"{pair.beside(link)}, {where}, by up to {1e3 * pair.depth:.2g} mm"
