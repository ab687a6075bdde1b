"""Names the colliders that do not collide, where other colliders of their links do."""

from collections.abc import Sequence

from linkwright.stages.robot.model.geometry import ColliderFigures, Exclude, Shape
from linkwright.stages.robot.text.plural import count

ColliderNames = tuple[str, ...]


def excluded_colliders(
    exclude: Exclude, shapes: Sequence[Shape], figures: Sequence[ColliderFigures]
) -> tuple[ColliderNames, ColliderNames] | None:
    """Names the colliders of `link_a` and of `link_b` that do not collide; None if no collider of the two
    links collides with the other link.

    Colliders of parts are named by their parts, with the number of their pieces if not all are meant; the
    user's colliders by kind and position. `figures`: of all links, as in `Geometry.colliders`.
    """
    if not exclude.geoms:
        return None
    positions_a, positions_b = ({pair[side] for pair in exclude.geoms} for side in (0, 1))
    return (
        _names(exclude.link_a, positions_a, shapes, figures),
        _names(exclude.link_b, positions_b, shapes, figures),
    )


def _names(
    link: str, positions: set[int], shapes: Sequence[Shape], figures: Sequence[ColliderFigures]
) -> ColliderNames:
    """Names the colliders at some positions among all colliders of a link."""
    colliders = [shape for shape in shapes if shape.link == link and shape.role == "collision"]
    figures_of_link = [collider_figures for collider_figures in figures if collider_figures.link == link]
    names: list[str] = []
    for position in sorted(positions):
        shape = colliders[position]
        # Only figures name the parts of a collider.
        if shape.collider is not None and shape.collider < len(figures_of_link):
            pieces = {index for index, piece in enumerate(colliders) if piece.collider == shape.collider}
            parts = figures_of_link[shape.collider].parts
            names.append(_part_collider_name(parts, len(positions & pieces), len(pieces)))
        else:
            kind = "mesh" if shape.primitive is None else shape.primitive.kind
            names.append(f"{kind} {position}")
    # Pieces of a collider share its name.
    return tuple(dict.fromkeys(names))


def _part_collider_name(parts: Sequence[str], meant_count: int, piece_count: int) -> str:
    share = "" if meant_count == piece_count else f" ({meant_count} of {count(piece_count, 'piece')})"
    return f"{', '.join(parts)}{share}"
