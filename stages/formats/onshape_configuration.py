"""Encodes Onshape's text for a configuration: `id=value;id2=value2`, or "default" for none.

Each value is encoded like a form field (a space is "+", "+" is "%2B"), so that `;`, `=` and `%` in a
value do not end it. As part of a query the whole text is percent-encoded once more.
"""

from collections.abc import Mapping
from urllib.parse import quote_plus, unquote_plus

DEFAULT = "default"


def encoded(value: str) -> str:
    """Returns a value, encoded for the text."""
    return quote_plus(value, safe="")


def decoded(value: str) -> str:
    """Returns the value that `encoded` wrote."""
    return unquote_plus(value)


def split(text: str) -> dict[str, str]:
    """Returns parameter id → its value, still encoded; empty for "default". The order is kept."""
    pairs = (item.partition("=") for item in text.split(";"))
    return {name: value for name, equals, value in pairs if equals and name}


def joined(values: Mapping[str, str]) -> str:
    """Returns the text of encoded values by parameter id."""
    return ";".join(f"{name}={value}" for name, value in values.items()) or DEFAULT
