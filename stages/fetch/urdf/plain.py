"""Checks that a URDF is not a xacro file under another name."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from linkwright.stages.fetch.urdf.expand import EXPAND_HINT
from linkwright.stages.robot.errors import SourceError

if TYPE_CHECKING:
    from linkwright.stages.formats.xml import Element

_XACRO_HINT = re.compile(r"xacro|\$[{(]")
_NAMED = re.compile(r"\{[^{}]*\bxacro/?\}|xacro:")
_EXPRESSION = re.compile(r"(?<!\$)\$(?:\{[^}]*\}|\([^)]*\))")
_MAX_QUOTED = 60
"""Largest length of an expression in a message."""


def require(text: str, where: str) -> None:
    """Raises SourceError if xacro would change this text: xacro expressions are neither run nor read
    literally. Elements for Gazebo are not read, and may contain anything."""
    if not _XACRO_HINT.search(text):
        return
    # Late: an unchanged source is not read again.
    from linkwright.stages.formats import xml

    try:
        root = xml.parse(text.encode())
    except xml.Malformed:
        return  # the reader reports the error
    gazebo_elements = {inner for outer in root.iterchildren("gazebo") for inner in outer.iter()}
    for element in root.iter():
        expression = "" if element in gazebo_elements else _first_expression(element)
        if expression:
            line = f"line {element.sourceline}"
            msg = f"{line}: {expression} is for xacro, and only a file called .xacro is expanded"
            name = f"{where.removesuffix('.urdf')}.urdf.xacro"
            hint = f"{EXPAND_HINT}; or rename it to {name} and, if you trust it, set source.trust=true"
            raise SourceError(msg, where, f"{hint} on the command line")


def _first_expression(element: Element) -> str:
    """Returns the first xacro expression in an element, its attributes or the texts in and behind it; "" if
    there is none."""
    namespace = element.nsmap.get("xacro")
    predicates = (_NAMED.match, lambda name: namespace is not None and name.startswith(f"{{{namespace}}}"))
    names = [element.tag, *element.keys()]
    for name in names:
        if any(is_of_xacro(name) for is_of_xacro in predicates):
            local_name = re.split(r"[}:]", name)[-1]
            return f"<xacro:{local_name}>" if name == element.tag else f'xacro:{local_name}="…"'
    for value in (*element.values(), element.text, element.tail):
        match = _EXPRESSION.search(value or "")
        if match:
            return match.group()[:_MAX_QUOTED]
    return ""
