"""Places the nodes of a tree, level by level, without overlap.

The algorithm is the tidy tree of Reingold and Tilford (IEEE Transactions on Software Engineering 7 (2),
1981), from left to right: subtrees are moved together until their contours are `gap` apart, and a parent is
at the middle of its children.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(slots=True)
class Contour:
    """The contour of a subtree. The levels are stored from the deepest up, with a common shift, so that
    adding a root and moving the subtree take constant time."""

    edges: list[tuple[float, float]]
    """The top and the bottom of each level, from the deepest level up to the root, before the shift."""

    shift: float = 0.0
    """The distance by which all edges are moved down."""

    def down_to(self, depth: int) -> list[tuple[float, float]]:
        """Returns the top and the bottom of the first `depth` levels, from the root on."""
        first_levels = self.edges[: -depth - 1 : -1]
        return [(top + self.shift, bottom + self.shift) for top, bottom in first_levels]


def tidy(
    order: Sequence[str], parents: Mapping[str, str], heights: Mapping[str, float], gap: float
) -> dict[str, float]:
    """Returns the vertical centre of each node; the topmost edge is at 0.

    `order`: all nodes, a parent before its children, the root (which has no entry in `parents`) first;
    children keep this order. `heights`: the height of each node's band.
    """
    children: dict[str, list[str]] = {name: [] for name in order}
    for name in order[1:]:
        children[parents[name]].append(name)
    contours: dict[str, Contour] = {}
    shifts: dict[str, float] = {}
    for name in reversed(order):
        merged = Contour([])
        offsets = []
        for child in children[name]:
            contour = contours.pop(child)
            shared = min(len(merged.edges), len(contour.edges))
            pairs = zip(merged.down_to(shared), contour.down_to(shared), strict=True)
            offset = max((above[1] + gap - below[0] for above, below in pairs), default=0.0)
            offsets.append(offset)
            contour.shift += offset
            merged = _joined_contours(merged, contour, shared)
        mean_offset = (offsets[0] + offsets[-1]) / 2 if offsets else 0.0
        shifts |= {child: offset - mean_offset for child, offset in zip(children[name], offsets, strict=True)}
        merged.shift -= mean_offset
        half = heights[name] / 2
        merged.edges.append((-half - merged.shift, half - merged.shift))
        contours[name] = merged
    contour = contours[order[0]]
    top_edge = min(top for top, _ in contour.edges) + contour.shift
    centres = {order[0]: -top_edge}
    for name in order[1:]:
        centres[name] = centres[parents[name]] + shifts[name]
    return centres


def _joined_contours(upper: Contour, lower: Contour, shared: int) -> Contour:
    """Joins two contours that have the first `shared` levels in common, by changing these levels of the
    deeper contour; returns it."""
    edges = [
        (top, bottom)
        for (top, _), (_, bottom) in zip(upper.down_to(shared), lower.down_to(shared), strict=True)
    ]
    deeper = upper if len(upper.edges) > len(lower.edges) else lower
    if shared:
        shifted = [(top - deeper.shift, bottom - deeper.shift) for top, bottom in reversed(edges)]
        deeper.edges[-shared:] = shifted
    return deeper


def levels(order: Sequence[str], parents: Mapping[str, str]) -> dict[str, int]:
    """Returns the number of edges from the root to each node."""
    depths = {order[0]: 0}
    for name in order[1:]:
        depths[name] = depths[parents[name]] + 1
    return depths
