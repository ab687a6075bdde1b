"""Limits the size of an MJCF: the counts by which a few bytes of XML would become a huge model."""

import re
from collections.abc import Iterable, Iterator
from math import prod
from pathlib import Path

from linkwright.stages.formats import xml
from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.system import regular_files

LARGEST_TEXT = 1 << 25
"""Largest size of an XML file [bytes]: a model of 10,000 bodies has a tenth of that."""

MAX_COPIES = 10_000
"""Largest number of elements that <replicate>, <composite> and <flexcomp> may make."""

MAX_COUNT = 10_000
"""Largest value of an attribute that allocates memory."""

MAX_CELLS = 1 << 26
"""Largest number of pixels of an image, or of points of a height field."""

MAX_BODIES = 20_000
"""Largest number of bodies: MuJoCo's compiler takes a minute for these, and its time grows with the
square."""

MAX_LETTERS = 1000
"""Largest length of a name."""

_NAMES = ("name", "model", "prefix", "class")
_COUNTS = re.compile(r"nkey|nuser\w*|dim|actdim|nsample")
_COPYING = ("replicate", "composite", "flexcomp")
_AREAS = {"hfield": ("nrow", "ncol"), "texture": ("width", "height")}


def require(path: Path, texts: Iterable[Path]) -> None:
    """Raises SourceError if the XML of the model `path`, in `texts`, exceeds a limit.

    Excesses that show only across several files, or in MuJoCo's own parser, are left to the limits of the
    guest process.
    """
    for text in texts:
        try:
            root = xml.parse(regular_files.content(text, LARGEST_TEXT), large=True)
        except (xml.Malformed, OSError, regular_files.FileTooLarge):
            continue  # MuJoCo reports that
        for why in _beyond(root):
            msg = f"it exceeds a size limit: {why}"
            raise SourceError(msg, path.name, "remove it, or lower the number")


def _beyond(root: Element) -> Iterator[str]:
    """Yields violations of the limits, such as "<size nkey> is 2000000000; at most 10000 is allowed"."""
    copies: dict[Element, float] = {}
    copied = bodies = 0.0
    for element in root.iter():
        above = copies.get(element.getparent(), 1.0)
        copies[element] = above * (max(1.0, _product(element, "count")) if element.tag in _COPYING else 1.0)
        copied = max(copied + (above if above > 1 else 0), copies[element] if copies[element] > 1 else 0)
        bodies += element.tag == "body"
        if copied > MAX_COPIES:
            copying = ", ".join(f"<{name}>" for name in _COPYING)
            yield f"its copies ({copying}) come to {copied:.6g} elements; at most {MAX_COPIES} are allowed"
            return
        yield from _large(element)
    if bodies > MAX_BODIES:
        yield f"it has {bodies:.0f} bodies; at most {MAX_BODIES} are allowed"


def _large(element: Element) -> Iterator[str]:
    """Yields violations of the limits in an element."""
    name = element.tag
    for key, value in element.items():
        if _COUNTS.fullmatch(key) and _number(value) > MAX_COUNT:
            yield f"<{name} {key}> is {_number(value):.12g}; at most {MAX_COUNT} is allowed"
        if key in _NAMES and len(value) > MAX_LETTERS:
            yield f"the {key} of a <{name}> has {len(value)} letters; at most {MAX_LETTERS} are allowed"
    if name in _AREAS:
        cells = prod(_product(element, key) for key in _AREAS[name])
        if cells > MAX_CELLS:
            yield f"<{name}> has {cells:.6g} points; at most {MAX_CELLS} are allowed"


def _product(element: Element, key: str) -> float:
    return prod(_number(text) for text in element.get(key, "").split())


def _number(text: str) -> float:
    """Returns a count; 1 if it is not a number (MuJoCo reports that)."""
    try:
        return float(text)
    except ValueError:
        return 1.0
