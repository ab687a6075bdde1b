"""Reports the figures of colliders, and the colliders that are flat, raw, or miss their tolerance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from linkwright.stages.mesh.collide.acceptance import miss
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.make import MadeCollider
from linkwright.stages.mesh.surfaces.pieces import vertices
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import ColliderFigures
from linkwright.stages.robot.text.globs import exact_glob, without_number
from linkwright.stages.robot.text.plural import count


def figures_of(made: MadeCollider, names: Sequence[str]) -> ColliderFigures:
    """Returns the figures of a collider; `names`: names of the parts that share it."""
    collision = made.collision
    return ColliderFigures(
        made.job.link,
        tuple(names),
        made.job.choice.maker,
        collision.rung,
        len(collision.pieces),
        sum(map(vertices, collision.pieces)),
        collision.meets,
        collision.tolerance,
        collision.measures,
        _miss_in_tolerances(collision),
        collision.note,
        collision.failed,
        made.job.identity(),
        collision.reason,
    )


def _miss_in_tolerances(collision: Collision) -> float | None:
    """Returns by how many tolerances a collider is off; for a collider by contact, by 95 % of its surface."""
    if collision.measures is None or collision.tolerance is None:
        return None
    return (
        collision.measures.protrusion_p95 / collision.tolerance
        if collision.reason
        else miss(collision.measures, collision.tolerance)
    )


def collider_reports(outcomes: Sequence[MadeCollider]) -> list[Diagnostic]:
    """Reports W-FLAT for links that are flat, W-COLLIDER for colliders that miss their tolerance, and I-RAW
    for meshes that serve as colliders."""
    return [*_flat_reports(outcomes), *_miss_reports(outcomes), *_raw_report(outcomes)]


def _flat_reports(outcomes: Sequence[MadeCollider]) -> Iterator[Diagnostic]:
    colliders_of_link: dict[str, list[MadeCollider]] = {}
    for collided in outcomes:
        if collided.job.choice.maker != "visual":
            colliders_of_link.setdefault(collided.job.link, []).append(collided)
    for link, made_colliders in colliders_of_link.items():
        if not any(collided.collision.pieces for collided in made_colliders):
            text = "the link is flat, so it has no convex hull and no collider"
            yield Diagnostic("W-FLAT", text, link, "give it thickness in CAD")


def _miss_reports(outcomes: Sequence[MadeCollider]) -> Iterator[Diagnostic]:
    """Yields W-COLLIDER once for each part, however often the part is used."""
    reported: set[tuple[str, str]] = set()
    for collided in outcomes:
        collision, job = collided.collision, collided.job
        if collision.meets or not collision.pieces:
            continue
        name = without_number(job.name)
        text = f"the collider of {name}, {_rung(collided)}, {_how_far(collided)}"
        if (name, text) in reported:
            continue
        reported.add((name, text))
        part_name = exact_glob(name.rpartition("/")[2])
        hint = (
            f'a larger tolerance or a collider by hand: `mesh: {{colliders: {{"{part_name}": {{make: ladder, '
            f"tolerance: {_met_tolerance(collided):.2g}}}}}}}`; or mesh.effort=high"
        )
        yield Diagnostic("W-COLLIDER", text, job.link, hint)


def _rung(collided: MadeCollider) -> str:
    collision = collided.collision
    if collision.rung == "pieces":
        return f"{len(collision.pieces)} convex pieces"
    return {"hull": "its convex hull"}.get(collision.rung, f"a {collision.rung}")


def _how_far(collided: MadeCollider) -> str:
    collision = collided.collision
    why = f" ({collision.note})" if collision.note else ""
    if collision.measures is None or collision.tolerance is None:
        return f"was not judged{why}"
    measures, mm = collision.measures, 1e3
    if miss(measures, collision.tolerance) <= 1:
        if measures.extra is None:
            return f"encloses a volume, but the part does not{why}"
        return f"adds {measures.extra:.0%} to the part's volume{why}"
    return (
        f"is not within the tolerance of {mm * collision.tolerance:.2g} mm: it stands out by "
        f"{mm * measures.protrusion_p95:.2g} mm (95 %) and {mm * measures.protrusion_max:.2g} mm (at most), "
        f"and leaves {mm * measures.bareness_max:.2g} mm of the part uncovered{why}"
    )


def _met_tolerance(collided: MadeCollider) -> float:
    """Returns a tolerance [m] that the collider meets, 5 % more than it misses by."""
    collision = collided.collision
    if collision.measures is None or collision.tolerance is None:
        return 0.001
    return 1.05 * max(1.0, miss(collision.measures, collision.tolerance)) * collision.tolerance


def _raw_report(outcomes: Sequence[MadeCollider]) -> Iterator[Diagnostic]:
    number = sum(len(collided.collision.pieces) for collided in outcomes if collided.collision.rung == "raw")
    if number:
        yield Diagnostic(
            "I-RAW",
            f"{count(number, 'mesh', 'meshes')} of parts serve as colliders as they are; MuJoCo takes the "
            "convex hull of each, which fills its hollows",
            "mesh.collider",
            "choose another mesh option where hollows matter",
        )
