"""Encodes Onshape's text for a configuration: `id=value;id2=value2`, or "default" for none.

Each value is encoded like a form field (a space is "+", "+" is "%2B"), so that `;`, `=` and `%` in a
value do not end it. As part of a query the whole text is percent-encoded once more.
"""

from collections.abc import Mapping
from urllib.parse import quote_plus, unquote_plus

DEFAULT = "default"
"""Onshape's text for a configuration without values."""


def encode_value(value: str) -> str:
    """Returns a value as the text of a configuration has it."""
    return quote_plus(value, safe="")


def decode_value(value: str) -> str:
    """Returns the value of an encoded value (see `encode_value`)."""
    return unquote_plus(value)


def split_configuration(text: str) -> dict[str, str]:
    """Returns parameter id → its value, still encoded, in the order of the text; empty for "default"."""
    pairs = (item.partition("=") for item in text.split(";"))
    return {name: value for name, equals, value in pairs if equals and name}


def join_configuration(values: Mapping[str, str]) -> str:
    """Returns the text of a configuration: `values` are encoded values by parameter id."""
    return ";".join(f"{name}={value}" for name, value in values.items()) or DEFAULT
