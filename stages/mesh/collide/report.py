"""What is reported of colliders: their figures, and those that are not what they should be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from linkwright.stages.mesh.collide.acceptance import miss
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.make import Collided
from linkwright.stages.mesh.surfaces.pieces import vertices
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import ColliderFigures
from linkwright.stages.robot.text.globs import escaped, unnumbered
from linkwright.stages.robot.text.plural import count


def figures_of(one: Collided, names: Sequence[str]) -> ColliderFigures:
    """The figures of a collider; `names`: of the parts that have it."""
    made = one.collision
    return ColliderFigures(
        one.job.link,
        tuple(names),
        one.job.choice.maker,
        made.rung,
        len(made.pieces),
        sum(map(vertices, made.pieces)),
        made.meets,
        made.tolerance,
        made.measures,
        _times_off(made),
        made.note,
        made.failed,
        one.job.identity(),
        made.reason,
    )


def _times_off(made: Collision) -> float | None:
    """How many times the tolerance it is off; a collider by contact by what 95 % of it stay within."""
    if made.measures is None or made.tolerance is None:
        return None
    return (
        made.measures.protrusion_p95 / made.tolerance if made.reason else miss(made.measures, made.tolerance)
    )


def colliders_reported(every: Sequence[Collided]) -> list[Diagnostic]:
    """W-COLLIDER for each part whose collider misses its tolerance, W-FLAT for links without one, I-RAW."""
    return [*_flat(every), *_missing(every), *_raw(every)]


def _flat(every: Sequence[Collided]) -> Iterator[Diagnostic]:
    of_links: dict[str, list[Collided]] = {}
    for one in every:
        if one.job.choice.maker != "visual":
            of_links.setdefault(one.job.link, []).append(one)
    for link, made in of_links.items():
        if not any(one.collision.pieces for one in made):
            text = "the link is flat, so it has no convex hull and no collider"
            yield Diagnostic("W-FLAT", text, link, "give it thickness in CAD")


def _missing(every: Sequence[Collided]) -> Iterator[Diagnostic]:
    """Each part once, wherever it is used."""
    told: set[tuple[str, str]] = set()
    for one in every:
        made, job = one.collision, one.job
        if made.meets or not made.pieces:
            continue
        name = unnumbered(job.name)
        text = f"the collider of {name}, {_rung(one)}, {_how_far(one)}"
        if (name, text) in told:
            continue
        told.add((name, text))
        own = escaped(name.rpartition("/")[2])
        hint = (
            f'a larger tolerance or a collider by hand: `mesh: {{colliders: {{"{own}": {{make: ladder, '
            f"tolerance: {_wanted(one):.2g}}}}}}}`; or mesh.effort=high"
        )
        yield Diagnostic("W-COLLIDER", text, job.link, hint)


def _rung(one: Collided) -> str:
    made = one.collision
    if made.rung == "pieces":
        return f"{len(made.pieces)} convex pieces"
    return {"hull": "its convex hull"}.get(made.rung, f"a {made.rung}")


def _how_far(one: Collided) -> str:
    made = one.collision
    why = f" ({made.note})" if made.note else ""
    if made.measures is None or made.tolerance is None:
        return f"was not judged{why}"
    found, mm = made.measures, 1e3
    if miss(found, made.tolerance) <= 1:
        if found.extra is None:
            return f"has a volume, which the part has not{why}"
        return f"adds {found.extra:.0%} to the part's volume{why}"
    return (
        f"is not within the tolerance of {mm * made.tolerance:.2g} mm: it stands out by "
        f"{mm * found.protrusion_p95:.2g} mm (95 %) and {mm * found.protrusion_max:.2g} mm (at most), and "
        f"leaves {mm * found.bareness_max:.2g} mm of the part bare{why}"
    )


def _wanted(one: Collided) -> float:
    """A tolerance [m] that the collider meets."""
    made = one.collision
    if made.measures is None or made.tolerance is None:
        return 0.001
    return 1.05 * max(1.0, miss(made.measures, made.tolerance)) * made.tolerance


def _raw(every: Sequence[Collided]) -> Iterator[Diagnostic]:
    number = sum(len(one.collision.pieces) for one in every if one.collision.rung == "raw")
    if number:
        yield Diagnostic(
            "I-RAW",
            f"{count(number, 'mesh', 'meshes')} of parts serve as colliders as they are; MuJoCo takes the "
            "convex hull of each, which fills its hollows",
            "mesh.collider",
            "choose another mesh option where hollows matter",
        )
