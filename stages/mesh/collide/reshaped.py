"""Reports how the limits of the engines in `target` change colliders and meshes."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, transform_surface
from linkwright.stages.mesh.collide import primitives
from linkwright.stages.mesh.collide.choices import Choice
from linkwright.stages.mesh.collide.make import MadeCollider
from linkwright.stages.mesh.configuration.collider_settings import RawSettings
from linkwright.stages.mesh.surfaces.pieces import half_spaces
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.model.robot import Link, Part, Primitive
from linkwright.stages.robot.text.plural import count
from linkwright.stages.targets.diagnostic import replacement_diagnostic, targets_where
from linkwright.stages.targets.engines import shape_limits

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import MeshSection

ColliderWithParts = tuple[MadeCollider, Sequence[Part]]
"""A collider, and the parts for which it was made."""


def target_reports(
    links: Sequence[Link],
    colliders: Sequence[ColliderWithParts],
    makers: Collection[Choice],
    shapes: Sequence[Shape],
    section: "MeshSection",
    targets: Sequence[str],
) -> Iterator[Diagnostic]:
    """Yields I-TARGET for everything that targets change in colliders and meshes. `makers`: the choices of
    collider makers; `shapes`: all shapes of the robot (a mesh with a texture is an OBJ in any case)."""
    yield from _cylinder_replacements(links, [collided for collided, _ in colliders], targets)
    yield from _ellipsoid_replacements(colliders, targets)
    limits = shape_limits(targets)
    capping_targets = targets_where(targets, lambda shapes: shapes.max_hull_vertices is not None)
    if limits.max_hull_vertices is not None:
        raw = sum(isinstance(collided.job.choice.settings, RawSettings) for collided, _ in colliders)
        if raw:
            number = count(raw, "collider that is a mesh as it is", "colliders that are meshes as they are")
            yield replacement_diagnostic(
                f"{number} → hulls of at most {limits.max_hull_vertices} vertices", capping_targets
            )
        capped = _vertex_counts_above(makers, section, limits.max_hull_vertices)
        if capped:
            text = ", ".join(
                f"{key} ({chosen_count} → {limits.max_hull_vertices})" for key, chosen_count in capped.items()
            )
            yield replacement_diagnostic(
                f"hulls and convex pieces have fewer vertices: {text}", capping_targets
            )
    stl = [shape for shape in shapes if shape.file is not None and shape.texture is None]
    if limits.needs_obj and section.format != "obj" and section.assets == "files" and stl:
        number = count(len({shape.file for shape in stl}), "mesh", "meshes")
        yield replacement_diagnostic(
            f"{number} in STL → OBJ", targets_where(targets, lambda shapes: shapes.needs_obj)
        )


def _cylinder_replacements(
    links: Sequence[Link], outcomes: Sequence[MadeCollider], targets: Sequence[str]
) -> Iterator[Diagnostic]:
    without_cylinders = targets_where(targets, lambda shapes: "cylinder" in shapes.excluded_kinds)
    kinds = [shape.kind for link in links for shape in link.shapes if shape.collision]
    kinds += [
        piece.kind
        for collided in outcomes
        for piece in collided.collision.pieces
        if isinstance(piece, Primitive)
    ]
    if without_cylinders and "cylinder" in kinds:
        number = count(kinds.count("cylinder"), "collider that is a cylinder", "colliders that are cylinders")
        text = (
            f"prisms of {primitives.PRISM_SIDES} sides and the same volume, whose corners stand out by "
            f"{100 * (primitives.PRISM_GROWTH - 1):.1f} % of the radius"
        )
        yield replacement_diagnostic(f"{number} → {text}", without_cylinders)


def _ellipsoid_replacements(
    colliders: Sequence[ColliderWithParts], targets: Sequence[str]
) -> Iterator[Diagnostic]:
    without_ellipsoids = targets_where(targets, lambda shapes: "ellipsoid" in shapes.excluded_kinds)
    errors = [
        ellipsoid_error(transform_surface(piece, collided.job.link_from_subject), parts[0])
        for collided, parts in colliders
        if len(parts) == 1 and parts[0].form.ellipsoid
        for piece in collided.collision.pieces
        if isinstance(piece, Surface)
    ]
    if without_ellipsoids and errors:
        number = count(len(errors), "collider that is an ellipsoid", "colliders that are ellipsoids")
        text = f"hulls, whose surface is off by at most {100 * max(errors):.1f} % of the radius"
        yield replacement_diagnostic(f"{number} → {text}", without_ellipsoids)


def ellipsoid_error(hull: Surface, part: Part) -> float:
    """Returns the largest distance between a hull, in the link's frame, and the ellipsoid of a part, as a
    share of the ellipsoid's radius in that direction."""
    lengths = np.array(part.form.ellipsoid)
    part_from_link = np.linalg.inv(part.link_from_part)
    points = hull.vertices @ part_from_link[:3, :3].T + part_from_link[:3, 3]
    # Scaled to a ball of radius 1: shares of the radius in a direction stay the same.
    ball = Surface(points / (lengths / 2), hull.triangles)
    _, heights = half_spaces(ball)
    return float(max(np.linalg.norm(ball.vertices, axis=1).max() - 1, 1 - heights.min()))


def _vertex_counts_above(makers: Collection[Choice], section: "MeshSection", limit: int) -> Mapping[str, int]:
    """Returns, by key, the configured numbers of vertices that exceed a target's limit `limit`."""
    if not any(hasattr(maker.settings, "max_vertices") for maker in makers):
        return {}
    vertex_counts = {"mesh.max_vertices": section.max_vertices}
    vertex_counts |= {
        f"mesh.colliders.{glob}.max_vertices": keys.max_vertices or 0
        for glob, keys in section.colliders.items()
    }
    return {key: number for key, number in vertex_counts.items() if number > limit}
