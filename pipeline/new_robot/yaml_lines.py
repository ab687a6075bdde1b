"""Writes lines of YAML, and comments."""

import json
import math
import re
import textwrap
from collections.abc import Mapping
from typing import Any

from linkwright.stages.robot.text.printable import printable

WIDTH = 100
"""Largest width of a comment, in columns."""


def comment(text: str, indent: str = "", hanging: str = "") -> list[str]:
    """Returns a text as lines of comment; `hanging`: the start of the lines after the first."""
    start = f"{indent}# "
    wrapped = textwrap.wrap(
        printable(text),
        WIDTH,
        initial_indent=start,
        subsequent_indent=start + hanging,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return wrapped or [start.rstrip()]


def flow(value: Any) -> str:
    """Returns plain data in YAML's flow form: `{limits: [-1.57, 1.57], effort: 12}`. Texts have quotes, and
    `${` in them is escaped, so that it is not an interpolation."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(str(key))}: {flow(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, str):
        return json.dumps(printable(value).replace("${", "\\${"), ensure_ascii=False)
    if isinstance(value, float):
        return _number(value)
    return json.dumps(value)


def _number(value: float) -> str:
    """Returns a number that every version of YAML reads as one: 1.1 needs a point before an exponent, and has
    words of its own for infinite numbers and NaN."""
    if not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    text = json.dumps(value)
    return text if "." in text else text.replace("e", ".0e")


def entry(key: str, value: Any, indent: str = "", *, active: bool = True) -> str:
    """Returns the line `key: value`; if not `active`, as YAML to uncomment: with a # and no space."""
    return f"{indent}{'' if active else '#'}{_key(key)}: {flow(value)}"


def _key(text: str) -> str:
    is_plain = re.fullmatch(r"[A-Za-z_][\w.-]*", text, re.ASCII) and text.lower() not in _RESERVED_WORDS
    return text if is_plain else flow(text)


_RESERVED_WORDS = frozenset({"true", "false", "null", "yes", "no", "on", "off", "y", "n"})
"""Keys that YAML does not read as text."""
