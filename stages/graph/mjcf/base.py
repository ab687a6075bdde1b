"""Finds the fixed bodies, the floating bodies and the root of an MJCF."""

from collections.abc import Sequence

import numpy as np

from linkwright.stages.formats.mjcf.model import Mjcf, MjcfBody
from linkwright.stages.graph.mjcf.equalities import Closing


def _tops(mjcf: Mjcf) -> list[int]:
    return [number for number, body in enumerate(mjcf.bodies) if number and body.parent == 0]


def floats(body: MjcfBody) -> bool:
    return any(joint.type == "free" for joint in body.joints)


def base_of(mjcf: Mjcf) -> int | None:
    """The base: the only body below the world that is fixed, where every other body floats; else None."""
    standing = [number for number in _tops(mjcf) if not floats(mjcf.bodies[number])]
    return standing[0] if len(standing) == 1 and not mjcf.bodies[standing[0]].joints else None


def bodies_of(mjcf: Mjcf, found: Sequence[Closing], free: bool) -> list[int]:
    """The bodies that become links, with the world where something is fixed to it or moves relative to it.

    A single fixed body in the world's own frame is the base itself, so the world is no link; the same holds
    for a body in any frame that shall float (`free`).
    """
    tops = _tops(mjcf)
    everything = list(range(len(mjcf.bodies)))
    base = base_of(mjcf)
    if base is not None:
        in_place = bool(np.abs(mjcf.bodies[base].parent_from_body - np.eye(4)).max() < 1e-12)
        return everything[1:] if in_place or (free and len(tops) == 1) else everything
    standing = any(not floats(mjcf.bodies[number]) for number in tops)
    tied = any(0 in one.closure.bodies for one in found)
    return everything if standing or tied else everything[1:]


def joining(mjcf: Mjcf, found: Sequence[Closing]) -> list[Closing]:
    """The closures without which bodies would float apart: each becomes a joint of the tree."""
    top = _top_of(mjcf)
    standing = {number for number in _tops(mjcf) if not floats(mjcf.bodies[number])} | {0}
    trees = ({0 if top[body] in standing else top[body] for body in one.closure.bodies} for one in found)
    return [one for one, ends in zip(found, trees, strict=True) if len(ends) > 1]


def _top_of(mjcf: Mjcf) -> dict[int, int]:
    """The top-level body above each body; the world's is the world."""
    top: dict[int, int] = {}
    for number, body in enumerate(mjcf.bodies):
        top[number] = top[body.parent] if body.parent else number
    return top


def root_of(mjcf: Mjcf, there: Sequence[int]) -> int:
    """The world or the base; else the floating body with the most bodies below it, the first of equals."""
    if there[0] == 0:
        return 0
    base = base_of(mjcf)
    if base is not None:
        return base
    count = list(_top_of(mjcf).values())
    return min(_tops(mjcf), key=lambda number: (-count.count(number), number))
