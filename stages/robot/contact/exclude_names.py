"""The names of the colliders that do not collide, where the others of their links do."""

from collections.abc import Sequence

from linkwright.stages.robot.model.geometry import ColliderFigures, Exclude, Shape
from linkwright.stages.robot.text.plural import count

Names = tuple[str, ...]


def excluded_colliders(
    exclude: Exclude, shapes: Sequence[Shape], figures: Sequence[ColliderFigures]
) -> tuple[Names, Names] | None:
    """The colliders of `link_a` and of `link_b` that do not collide: by their parts, with the number of the
    pieces where not all of them are meant; what the user gave by its kind and its position. None where it is
    all of them. `figures`: of all links, as in `Geometry.colliders`.
    """
    if not exclude.geoms:
        return None
    one, other = ({pair[side] for pair in exclude.geoms} for side in (0, 1))
    return _names(exclude.link_a, one, shapes, figures), _names(exclude.link_b, other, shapes, figures)


def _names(link: str, meant: set[int], shapes: Sequence[Shape], figures: Sequence[ColliderFigures]) -> Names:
    colliders = [shape for shape in shapes if shape.link == link and shape.role == "collision"]
    own = [one for one in figures if one.link == link]
    found: dict[str, None] = {}
    for position in sorted(meant):
        shape = colliders[position]
        if shape.collider is not None and shape.collider < len(own):
            every = [at for at, other in enumerate(colliders) if other.collider == shape.collider]
            some = len(meant.intersection(every))
            share = "" if some == len(every) else f" ({some} of {count(len(every), 'piece')})"
            found[f"{', '.join(own[shape.collider].parts)}{share}"] = None
        else:
            kind = "mesh" if shape.primitive is None else shape.primitive.kind
            found[f"{kind} {position}"] = None
    return tuple(found)
