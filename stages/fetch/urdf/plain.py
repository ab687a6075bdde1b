"""Checks that a URDF is not a xacro file under another name."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from linkwright.stages.fetch.urdf.expand import EXPAND
from linkwright.stages.robot.errors import SourceError

if TYPE_CHECKING:
    from linkwright.stages.formats.xml import Element

_MAYBE = re.compile(r"xacro|\$[{(]")
_NAMED = re.compile(r"\{[^{}]*\bxacro/?\}|xacro:")
_EXPRESSION = re.compile(r"(?<!\$)\$(?:\{[^}]*\}|\([^)]*\))")
_MAX_QUOTED = 60
"""Largest length of an expression in a message."""


def require(text: str, where: str) -> None:
    """Raises SourceError if xacro would change this text: xacro expressions are neither run nor read
    literally. Elements for Gazebo are not read, and may contain anything."""
    if not _MAYBE.search(text):
        return
    # Late: an unchanged source is not read again.
    from linkwright.stages.formats import xml

    try:
        root = xml.parse(text.encode())
    except xml.Malformed:
        return  # the reader reports what is wrong with it
    gazebo_elements = {inner for outer in root.iterchildren("gazebo") for inner in outer.iter()}
    for element in root.iter():
        expression = "" if element in gazebo_elements else _for_xacro(element)
        if expression:
            line = f"line {element.sourceline}"
            msg = f"{line}: {expression} is for xacro, and only a file called .xacro is expanded"
            name = f"{where.removesuffix('.urdf')}.urdf.xacro"
            hint = f"{EXPAND}; or rename it to {name} and, if you trust it, set source.trust=true"
            raise SourceError(msg, where, f"{hint} on the command line")


def _for_xacro(element: Element) -> str:
    """Returns the first xacro expression in an element, its attributes or the texts in and behind it; "" if
    there is none."""
    namespace = element.nsmap.get("xacro")
    spaces = (_NAMED.match, lambda name: namespace is not None and name.startswith(f"{{{namespace}}}"))
    names = [element.tag, *element.keys()]
    for name in names:
        if any(of_xacro(name) for of_xacro in spaces):
            last = re.split(r"[}:]", name)[-1]
            return f"<xacro:{last}>" if name == element.tag else f'xacro:{last}="…"'
    for value in (*element.values(), element.text, element.tail):
        match = _EXPRESSION.search(value or "")
        if match:
            return match.group()[:_MAX_QUOTED]
    return ""
