"""Whether a URDF is one as it stands, or a xacro file by another name."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from stages.fetch.urdf.expand import EXPAND
from stages.robot.errors import SourceError

if TYPE_CHECKING:
    from stages.formats.xml import Element

_MAYBE = re.compile(r"xacro|\$[{(]")
_NAMED = re.compile(r"\{[^{}]*\bxacro/?\}|xacro:")
_EXPRESSION = re.compile(r"(?<!\$)\$(?:\{[^}]*\}|\([^)]*\))")
_LONGEST = 60


def require(text: str, where: str) -> None:
    """SourceError where xacro would make another text of this one: what it would replace is neither run
    nor taken as it stands. What is for Gazebo is not read, and may hold anything."""
    if not _MAYBE.search(text):
        return
    from stages.formats import xml

    try:
        root = xml.parse(text.encode())
    except xml.Malformed:
        return  # the reader reports what is wrong with it
    beside = {inner for outer in root.iterchildren("gazebo") for inner in outer.iter()}
    for element in root.iter():
        found = "" if element in beside else _for_xacro(element)
        if found:
            msg = (
                f"line {element.sourceline}: {found} is for xacro, and only a file called .xacro is expanded"
            )
            name = f"{where.removesuffix('.urdf')}.urdf.xacro"
            hint = f"{EXPAND}; or rename it to {name} and, if you trust it, set source.trust=true"
            raise SourceError(msg, where, f"{hint} on the command line")


def _for_xacro(element: Element) -> str:
    """What of an element, its attributes and the texts in and behind it xacro would replace; "" without."""
    own = element.nsmap.get("xacro")
    spaces = (_NAMED.match, lambda name: own is not None and name.startswith(f"{{{own}}}"))
    names = [element.tag, *element.keys()]
    for name in names:
        if any(of_xacro(name) for of_xacro in spaces):
            last = re.split(r"[}:]", name)[-1]
            return f"<xacro:{last}>" if name == element.tag else f'xacro:{last}="…"'
    for value in (*element.values(), element.text, element.tail):
        found = _EXPRESSION.search(value or "")
        if found:
            return found.group()[:_LONGEST]
    return ""
