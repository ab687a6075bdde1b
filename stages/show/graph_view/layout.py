"""Where the nodes of a tree go, level by level, so that none overlap.

The tidy tree of Reingold and Tilford (IEEE Transactions on Software Engineering 7 (2), 1981), from
left to right: subtrees are moved together until their contours are `gap` apart, and a parent stands at
the middle of its children.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(slots=True)
class Contour:
    """The top and the bottom of a subtree at each level, from its deepest up to its root, all to be moved
    down by `shift`: so neither a new root nor a move touches what lies below."""

    edges: list[tuple[float, float]]
    shift: float = 0.0

    def down_to(self, depth: int) -> list[tuple[float, float]]:
        """The first levels, from the root on."""
        there = self.edges[: -depth - 1 : -1]
        return [(top + self.shift, bottom + self.shift) for top, bottom in there]


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
        merged = Contour([])
        places = []
        for child in children[name]:
            own = contours.pop(child)
            shared = min(len(merged.edges), len(own.edges))
            pairs = zip(merged.down_to(shared), own.down_to(shared), strict=True)
            place = max((above[1] + gap - below[0] for above, below in pairs), default=0.0)
            places.append(place)
            own.shift += place
            merged = _together(merged, own, shared)
        middle = (places[0] + places[-1]) / 2 if places else 0.0
        shifts |= {child: place - middle for child, place in zip(children[name], places, strict=True)}
        merged.shift -= middle
        half = heights[name] / 2
        merged.edges.append((-half - merged.shift, half - merged.shift))
        contours[name] = merged
    whole = contours[order[0]]
    highest = min(top for top, _ in whole.edges) + whole.shift
    centres = {order[0]: -highest}
    for name in order[1:]:
        centres[name] = centres[parents[name]] + shifts[name]
    return centres


def _together(above: Contour, below: Contour, shared: int) -> Contour:
    """The contour of both, which share so many levels: the deeper one, changed where they do."""
    edges = [
        (top, bottom)
        for (top, _), (_, bottom) in zip(above.down_to(shared), below.down_to(shared), strict=True)
    ]
    deeper = above if len(above.edges) > len(below.edges) else below
    if shared:
        moved = [(top - deeper.shift, bottom - deeper.shift) for top, bottom in reversed(edges)]
        deeper.edges[-shared:] = moved
    return deeper


def levels(order: Sequence[str], parents: Mapping[str, str]) -> dict[str, int]:
    """The number of edges from the root to each node."""
    found = {order[0]: 0}
    for name in order[1:]:
        found[name] = found[parents[name]] + 1
    return found
