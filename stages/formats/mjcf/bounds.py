"""Limits the size of an MJCF, in which a few bytes of XML can describe a huge model."""

import re
from collections.abc import Iterable, Iterator
from math import prod
from pathlib import Path

from linkwright.stages.formats import xml
from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.system import regular_files

MAX_XML_BYTES = 1 << 25
"""Largest size of an XML file [bytes]: ten times that of a model with 10,000 bodies."""

MAX_COPIES = 10_000
"""Largest number of copies of elements that all <replicate>, <composite> and <flexcomp> of a file may make
together. If such an element is empty, each of its own copies counts."""

MAX_COUNT = 10_000
"""Largest value of an attribute by which MuJoCo allocates memory."""

MAX_CELLS = 1 << 26
"""Largest number of pixels of an image, or of points of a height field."""

MAX_BODIES = 20_000
"""Largest number of bodies: MuJoCo's compiler takes a minute for that many, and its time grows with the
square of the number."""

MAX_NAME_LENGTH = 1000
"""Largest number of letters of a name."""

_NAME_ATTRIBUTES = ("name", "model", "prefix", "class")
"""Attributes of any element that are names."""

_COUNT_ATTRIBUTES = re.compile(r"nkey|nuser\w*|dim|actdim|nsample")
"""Attributes of any element that `MAX_COUNT` limits."""

_COPYING_TAGS = ("replicate", "composite", "flexcomp")
"""Elements that make copies; `count` has their number, or the numbers along several axes."""

_SIZE_ATTRIBUTES = {"hfield": ("nrow", "ncol"), "texture": ("width", "height")}
"""Element → the attributes whose product is its number of cells."""


def require_within_limits(xml_files: Iterable[Path]) -> None:
    """Raises SourceError if a file of a model exceeds a limit. `xml_files`: all files of the model, the main
    file included.

    Each file is judged by itself. A model that is too large only across several files, or only for
    MuJoCo's own parser, is stopped by the limits of the guest process.
    """
    for xml_file in xml_files:
        try:
            root = xml.parse(regular_files.content(xml_file, MAX_XML_BYTES), large=True)
        except (xml.Malformed, OSError, regular_files.FileTooLarge):
            # MuJoCo reports a malformed or unreadable file; a file that is too large was refused before
            # (`fetch.mjcf.files`).
            continue
        for violation in _violations(root):
            msg = f"it exceeds a size limit: {violation}"
            raise SourceError(msg, xml_file.name, "remove or reduce it")


def _violations(root: Element) -> Iterator[str]:
    """Yields violations of the limits, such as "<size nkey> is 2000000000; at most 10000 is allowed"."""
    # Element → the number of copies of each element in it.
    copies_inside: dict[Element, float] = {}
    copied_elements = 0.0
    body_count = 0
    for element in root.iter():
        copies = copies_inside.get(element.getparent(), 1.0)
        factor = max(1.0, _product(element, "count")) if element.tag in _COPYING_TAGS else 1.0
        copies_inside[element] = copies * factor
        # <composite> and <flexcomp> make copies even without child elements.
        made_copies = copies if len(element) else copies_inside[element]
        if made_copies > 1:
            copied_elements += made_copies
        if copied_elements > MAX_COPIES:
            tags = ", ".join(f"<{tag}>" for tag in _COPYING_TAGS)
            yield (
                f"its copies ({tags}) come to {copied_elements:.6g} elements; "
                f"at most {MAX_COPIES} are allowed"
            )
            return
        body_count += element.tag == "body"
        yield from _attribute_violations(element)
    if body_count > MAX_BODIES:
        yield f"it has {body_count} bodies; at most {MAX_BODIES} are allowed"


def _attribute_violations(element: Element) -> Iterator[str]:
    """Yields violations of the limits by the attributes of an element."""
    tag = element.tag
    for key, value in element.items():
        if _COUNT_ATTRIBUTES.fullmatch(key) and _number(value) > MAX_COUNT:
            yield f"<{tag} {key}> is {_number(value):.12g}; at most {MAX_COUNT} is allowed"
        if key in _NAME_ATTRIBUTES and len(value) > MAX_NAME_LENGTH:
            yield f"the {key} of a <{tag}> has {len(value)} letters; at most {MAX_NAME_LENGTH} are allowed"
    if tag in _SIZE_ATTRIBUTES:
        cells = prod(_product(element, key) for key in _SIZE_ATTRIBUTES[tag])
        if cells > MAX_CELLS:
            unit = "pixels" if tag == "texture" else "points"
            yield f"<{tag}> has {cells:.6g} {unit}; at most {MAX_CELLS} are allowed"


def _product(element: Element, key: str) -> float:
    """Returns the product of the numbers in an attribute; 1 without the attribute."""
    return prod(_number(text) for text in element.get(key, "").split())


def _number(text: str) -> float:
    """Returns the number in a text; 1 if it is not a number, which MuJoCo reports."""
    try:
        return float(text)
    except ValueError:
        return 1.0
