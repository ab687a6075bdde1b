"""What the configuration's own XML changed in a file that a build would write again without it."""

from collections.abc import Iterable

from linkwright.stages.robot.model.amendments import Amendment, tag_of
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.rewritten.compare import Difference

PREFIX = "${prefix}"
"""Before the names of a xacro."""


def is_amended(difference: Difference, changes: Iterable[Amendment]) -> bool:
    """Whether a difference is one of these changes, by its element and attribute."""
    element = difference.finding.element.replace(PREFIX, "")
    return any(_is_of(difference, element, change) for change in changes)


def _is_of(difference: Difference, element: str, change: Amendment) -> bool:
    attribute = difference.finding.attribute
    if element == _element(change.target):
        words = attribute.split()
        return bool(words) and (words[-1] in change.sets or words[0] in change.added_tags)
    return difference.change == "added" and element in map(_element, change.adds)


def _element(said: str) -> str:
    """As findings name it, of "body torso"."""
    tag, _, name = said.partition(" ")
    return named(tag_of(tag), name)
