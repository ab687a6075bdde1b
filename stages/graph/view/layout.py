"""Where the nodes of a tree go, level by level, so that none overlap.

The tidy tree of Reingold and Tilford (IEEE Transactions on Software Engineering 7 (2), 1981), from
left to right: subtrees are moved together until their contours are `gap` apart, and a parent stands at
the middle of its children.
"""

from collections.abc import Mapping, Sequence

Contour = list[tuple[float, float]]
"""The top and the bottom of a subtree at each level, from its root on."""


def tidy(
    order: Sequence[str], parents: Mapping[str, str], heights: Mapping[str, float], gap: float
) -> dict[str, float]:
    """The vertical centre of every node; the topmost edge is at 0.

    `order`: all nodes, a parent before its children, the root (which has no entry in `parents`)
    first; children stand in this order. `heights`: the band that a node takes.
    """
    children: dict[str, list[str]] = {name: [] for name in order}
    for name in order[1:]:
        children[parents[name]].append(name)
    contours: dict[str, Contour] = {}
    shifts: dict[str, float] = {}
    for name in reversed(order):
        merged: Contour = []
        places = []
        for child in children[name]:
            own = contours.pop(child)
            pairs = zip(merged, own, strict=False)
            place = max((above[1] + gap - below[0] for above, below in pairs), default=0.0)
            places.append(place)
            merged = _together(merged, own, place)
        middle = (places[0] + places[-1]) / 2 if places else 0.0
        shifts |= {child: place - middle for child, place in zip(children[name], places, strict=True)}
        half = heights[name] / 2
        contours[name] = [(-half, half), *((top - middle, bottom - middle) for top, bottom in merged)]
    highest = min(top for top, _ in contours[order[0]])
    centres = {order[0]: -highest}
    for name in order[1:]:
        centres[name] = centres[parents[name]] + shifts[name]
    return centres


def _together(above: Contour, below: Contour, shift: float) -> Contour:
    """The contour of both, `below` moved down by `shift`."""
    moved = [(top + shift, bottom + shift) for top, bottom in below]
    shared = min(len(above), len(moved))
    both = [(above[level][0], moved[level][1]) for level in range(shared)]
    return both + above[shared:] + moved[shared:]


def levels(order: Sequence[str], parents: Mapping[str, str]) -> dict[str, int]:
    """How many edges each node is from the root."""
    found = {order[0]: 0}
    for name in order[1:]:
        found[name] = found[parents[name]] + 1
    return found
