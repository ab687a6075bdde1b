"""What is reported of pairs of links that touch."""

from collections.abc import Iterator, Mapping

from stages.robot.adjacency import Pair
from stages.robot.errors import Diagnostic
from stages.robot.globs import as_key
from stages.robot.plural import count

_WHERE = "contact"


def findings(always: Mapping[Pair, float], free: Mapping[Pair, float], poses: int) -> Iterator[Diagnostic]:
    """I-ALWAYS-CONTACT with the pairs that touch in every one of so many poses, and W-SELF-CONTACT with those
    that touch at `home` but not in every pose, each with its depth [m] there."""
    if always:
        text = f"{_pairs(always)} in every one of {poses} poses, so they do not collide: {_listed(always)}"
        yield Diagnostic("I-ALWAYS-CONTACT", text, _WHERE, "contact.self=all lets them collide")
    if free:
        text = f"{_pairs(free)} at home, but not in every pose: {_listed(free)}"
        lines = ", ".join(f"[{as_key(one)}, {as_key(other)}]" for one, other in free)
        hint = (
            f"to let them pass through each other: `contact: {{exclude: [{lines}]}}`; "
            "otherwise change the pose or the shapes"
        )
        yield Diagnostic("W-SELF-CONTACT", text, _WHERE, hint)


def _pairs(depths: Mapping[Pair, float]) -> str:
    return f"{count(len(depths), 'pair')} of links {'touches' if len(depths) == 1 else 'touch'}"


def _listed(depths: Mapping[Pair, float]) -> str:
    """The pairs with their depths in mm."""
    return ", ".join(
        f"{one} and {other} ({1e3 * depth:.2f} mm deep)" for (one, other), depth in depths.items()
    )
