"""Names the colliders that do not collide, where other colliders of their links do."""

from collections.abc import Sequence

from linkwright.stages.robot.model.geometry import ColliderFigures, Exclude, Shape
from linkwright.stages.robot.text.plural import count

Names = tuple[str, ...]


def excluded_colliders(
    exclude: Exclude, shapes: Sequence[Shape], figures: Sequence[ColliderFigures]
) -> tuple[Names, Names] | None:
    """Names the colliders of `link_a` and of `link_b` that do not collide; None if no collider of the two
    links collides with the other link.

    Colliders of parts are named by their parts, with the number of their pieces if not all are meant; the
    user's colliders by kind and position. `figures`: of all links, as in `Geometry.colliders`.
    """
    if not exclude.geoms:
        return None
    of_a, of_b = ({pair[side] for pair in exclude.geoms} for side in (0, 1))
    return _names(exclude.link_a, of_a, shapes, figures), _names(exclude.link_b, of_b, shapes, figures)


def _names(link: str, meant: set[int], shapes: Sequence[Shape], figures: Sequence[ColliderFigures]) -> Names:
    colliders = [shape for shape in shapes if shape.link == link and shape.role == "collision"]
    of_link = [collider_figures for collider_figures in figures if collider_figures.link == link]
    names: dict[str, None] = {}
    for position in sorted(meant):
        shape = colliders[position]
        if shape.collider is not None and shape.collider < len(of_link):
            pieces = [index for index, other in enumerate(colliders) if other.collider == shape.collider]
            some = len(meant.intersection(pieces))
            share = "" if some == len(pieces) else f" ({some} of {count(len(pieces), 'piece')})"
            names[f"{', '.join(of_link[shape.collider].parts)}{share}"] = None
        else:
            kind = "mesh" if shape.primitive is None else shape.primitive.kind
            names[f"{kind} {position}"] = None
    return tuple(names)
