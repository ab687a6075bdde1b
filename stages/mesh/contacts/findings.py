"""What is reported of pairs of links that touch."""

from collections.abc import Iterator, Sequence

from linkwright.stages.robot.contact.exclude_names import Names
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Exclude, Touch
from linkwright.stages.robot.text.globs import as_key, listed
from linkwright.stages.robot.text.plural import count

_WHERE = "contact"


def findings(
    always: Sequence[tuple[Exclude, tuple[Names, Names] | None]], free: Sequence[Touch], poses: int
) -> Iterator[Diagnostic]:
    """I-ALWAYS-CONTACT with the pairs that touch in every one of so many poses, and the names of what does
    not collide where that is not all of them; and W-SELF-CONTACT with those that touch at `home`, but not in
    every pose. Each has its depth there."""
    if always:
        told = "; ".join(_pair(one) + _only(names) for one, names in always)
        text = f"{_pairs(len(always))} in every one of {poses} poses, so they do not collide: {told}"
        yield Diagnostic("I-ALWAYS-CONTACT", text, _WHERE, "contact.self=all lets them collide")
    if free:
        text = f"{_pairs(len(free))} at home, but not in every pose: {', '.join(map(_pair, free))}"
        lines = ", ".join(f"[{as_key(one.link_a)}, {as_key(one.link_b)}]" for one in free)
        hint = (
            f"to let them pass through each other: `contact: {{exclude: [{lines}]}}`; "
            "otherwise change the pose or the shapes"
        )
        yield Diagnostic("W-SELF-CONTACT", text, _WHERE, hint)


def _pairs(number: int) -> str:
    return f"{count(number, 'pair')} of links {'touches' if number == 1 else 'touch'}"


def _pair(one: Exclude | Touch) -> str:
    """The pair with its depth in mm."""
    return f"{one.link_a} and {one.link_b} ({1e3 * one.depth:.2f} mm deep)"


def _only(names: tuple[Names, Names] | None) -> str:
    """What of the pair does not collide."""
    if names is None:
        return ""
    return f", of which only {listed(names[0])} against {listed(names[1])}"
