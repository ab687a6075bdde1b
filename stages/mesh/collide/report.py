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

_MM = 1e3
"""Millimetres in a metre."""

_UNJUDGED_TOLERANCE = 0.001
"""The tolerance [m] to try for a collider that was not judged."""


def figures_of(made: MadeCollider, names: Sequence[str]) -> ColliderFigures:
    """Returns the figures of a collider; `names`: names of the parts that share it."""
    collision = made.collision
    return ColliderFigures(
        link=made.job.link,
        parts=tuple(names),
        maker=made.job.choice.maker,
        rung=collision.rung,
        pieces=len(collision.pieces),
        vertices=sum(map(vertices, collision.pieces)),
        meets=collision.meets,
        tolerance=collision.tolerance,
        measures=collision.measures,
        miss=_miss_in_tolerances(collision),
        note=collision.note,
        failed=collision.failed,
        key=made.job.identity(),
        reason=collision.reason,
    )


def _miss_in_tolerances(collision: Collision) -> float | None:
    """Returns by how many tolerances a collider is off; None for a collider that was not judged. A collider
    by contact is judged by the protrusion that 95 % of its surface does not exceed."""
    if collision.measures is None or collision.tolerance is None:
        return None
    if collision.reason:
        return collision.measures.protrusion_p95 / collision.tolerance
    return miss(collision.measures, collision.tolerance)


def collider_reports(made_colliders: Sequence[MadeCollider]) -> list[Diagnostic]:
    """Reports W-FLAT for links that are flat, W-COLLIDER for colliders that miss their tolerance, and I-RAW
    for meshes that serve as colliders."""
    return [*_flat_reports(made_colliders), *_miss_reports(made_colliders), *_raw_report(made_colliders)]


def _flat_reports(made_colliders: Sequence[MadeCollider]) -> Iterator[Diagnostic]:
    colliders_of_link: dict[str, list[MadeCollider]] = {}
    for made in made_colliders:
        if made.job.choice.maker != "visual":
            colliders_of_link.setdefault(made.job.link, []).append(made)
    for link, colliders in colliders_of_link.items():
        if not any(made.collision.pieces for made in colliders):
            text = "the link is flat, so it has no convex hull and no collider"
            yield Diagnostic("W-FLAT", text, link, "give it thickness in CAD")


def _miss_reports(made_colliders: Sequence[MadeCollider]) -> Iterator[Diagnostic]:
    """Yields W-COLLIDER once for each part, however often the part is used."""
    reported: set[tuple[str, str]] = set()
    for made in made_colliders:
        collision, job = made.collision, made.job
        if collision.meets or not collision.pieces:
            continue
        name = without_number(job.name)
        text = f"the collider of {name}, {_kind_in_words(made)}, {_miss_in_words(made)}"
        if (name, text) in reported:
            continue
        reported.add((name, text))
        part_name = exact_glob(name.rpartition("/")[2])
        hint = (
            f'a larger tolerance or a collider by hand: `mesh: {{colliders: {{"{part_name}": {{make: ladder, '
            f"tolerance: {_met_tolerance(made):.2g}}}}}}}`; or mesh.effort=high"
        )
        yield Diagnostic("W-COLLIDER", text, job.link, hint)


def _kind_in_words(made: MadeCollider) -> str:
    collision = made.collision
    if collision.rung == "pieces":
        return f"{len(collision.pieces)} convex pieces"
    if collision.rung == "hull":
        return "its convex hull"
    return f"a {collision.rung}"


def _miss_in_words(made: MadeCollider) -> str:
    collision = made.collision
    why = f" ({collision.note})" if collision.note else ""
    if collision.measures is None or collision.tolerance is None:
        return f"was not judged{why}"
    measures = collision.measures
    if miss(measures, collision.tolerance) <= 1:
        if measures.extra is None:
            return f"encloses a volume, but the part does not{why}"
        return f"adds {measures.extra:.0%} to the part's volume{why}"
    return (
        f"is not within the tolerance of {_MM * collision.tolerance:.2g} mm: it stands out by "
        f"{_MM * measures.protrusion_p95:.2g} mm (95 %) and {_MM * measures.protrusion_max:.2g} mm (at most"
        f"), and leaves {_MM * measures.bareness_max:.2g} mm of the part uncovered{why}"
    )


def _met_tolerance(made: MadeCollider) -> float:
    """Returns a tolerance [m] that the collider would meet: its error, and 5 % more."""
    collision = made.collision
    if collision.measures is None or collision.tolerance is None:
        return _UNJUDGED_TOLERANCE
    return 1.05 * max(1.0, miss(collision.measures, collision.tolerance)) * collision.tolerance


def _raw_report(made_colliders: Sequence[MadeCollider]) -> Iterator[Diagnostic]:
    raw_meshes = sum(len(made.collision.pieces) for made in made_colliders if made.collision.rung == "raw")
    if raw_meshes:
        yield Diagnostic(
            "I-RAW",
            f"{count(raw_meshes, 'mesh', 'meshes')} of parts serve as colliders as they are; MuJoCo takes "
            "the convex hull of each, which fills its hollows",
            "mesh.collider",
            "choose another mesh option where hollows matter",
        )
