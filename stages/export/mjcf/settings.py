"""Formats the values of MuJoCo's settings as attributes."""

from typing import Any

from linkwright.stages.formats.numbers import number


def attribute_text(value: Any) -> str:
    """Returns the text of a word, a switch, a number, or a sequence of these separated by spaces."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if isinstance(value, int):
        return str(value)
    return number(value) if isinstance(value, float) else " ".join(attribute_text(item) for item in value)
