"""Recognizes differences that come from the keys `elements` and `attributes`: the expected content, which a
build would write, lacks their changes."""

from collections.abc import Iterable

from linkwright.stages.robot.model.amendments import Amendment, tag_of
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.rewritten.compare import Difference

PREFIX = "${prefix}"
"""The parameter with which names in a xacro begin; targets lack it."""


def is_amended(difference: Difference, changes: Iterable[Amendment]) -> bool:
    """Tells whether a difference comes from one of these changes, by its element and attribute."""
    element = difference.finding.element.replace(PREFIX, "")
    return any(_comes_from(difference, element, change) for change in changes)


def _comes_from(difference: Difference, element: str, change: Amendment) -> bool:
    attribute = difference.finding.attribute
    if element == _finding_title(change.target):
        # An attribute is "pos", or "inertial pos" for an attribute of a child.
        words = attribute.split()
        return bool(words) and (words[-1] in change.sets or words[0] in change.added_tags)
    # An added element has its own title, not that of the target.
    return difference.change == "added" and element in map(_finding_title, change.adds)


def _finding_title(target: str) -> str:
    """Returns the title that findings give to a target: `body "torso"` for "body torso"."""
    tag, _, name = target.partition(" ")
    return named(tag_of(tag), name)
