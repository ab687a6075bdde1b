"""Recognizes differences that come from the user's own XML, which a build would not write again."""

from collections.abc import Iterable

from linkwright.stages.robot.model.amendments import Amendment, tag_of
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.rewritten.compare import Difference

PREFIX = "${prefix}"
"""Prefix of the names in a xacro."""


def is_amended(difference: Difference, changes: Iterable[Amendment]) -> bool:
    """Tells, by its element and attribute, whether a difference comes from these changes."""
    element = difference.finding.element.replace(PREFIX, "")
    return any(_is_of(difference, element, change) for change in changes)


def _is_of(difference: Difference, element: str, change: Amendment) -> bool:
    attribute = difference.finding.attribute
    if element == _element(change.target):
        words = attribute.split()
        return bool(words) and (words[-1] in change.sets or words[0] in change.added_tags)
    return difference.change == "added" and element in map(_element, change.adds)


def _element(target: str) -> str:
    """Returns the title, in findings, of a target such as "body torso"."""
    tag, _, name = target.partition(" ")
    return named(tag_of(tag), name)
