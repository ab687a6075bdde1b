"""A model file as XML, with what it includes: its elements, what each is called, and where it lies."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from linkwright.stages.formats.mjcf.bounds import LARGEST_TEXT
from linkwright.stages.formats.own_xml import name_of
from linkwright.stages.formats.xml import Element, Malformed, parse, tag
from linkwright.stages.mujoco.includes import resolve
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.system.regular_files import FileTooLarge, content, is_file
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import named

Language = Literal["urdf", "mjcf"]

ROOTS: dict[str, Language] = {"robot": "urdf", "mujoco": "mjcf"}
"""The root elements of models, and the languages that they begin."""

MAKERS = frozenset(["attach", "replicate", "composite", "flexcomp", "flex", "plugin", "model"])
"""Elements of an MJCF that make others, with names and joints that are not in the text."""

SHOWN = 3
"""So many findings are written out in a check's own words."""

MOST_INCLUDES = 100
"""Files that a model may include."""


@dataclass(frozen=True, slots=True, eq=False)
class ModelDocument:
    """`root`: the model with what it includes; `included`: the elements of other files, and these files.
    `language` is None where the root is of no model. `broken`: what of the text cannot be read.
    `packages`: those that the file's own folder is to it, None where nothing is known of that. `foreign`:
    whether another program wrote it."""

    path: Path
    root: Element
    language: Language | None
    included: dict[Element, Path]
    broken: tuple[Finding, ...] = ()
    packages: tuple[str, ...] | None = None
    foreign: bool = False

    def elements(self) -> Iterator[Element]:
        """The elements of this file itself, in its order."""
        return (one for one in self.root.iter() if one not in self.included)

    def finding(self, element: Element, attribute: str, message: str) -> Finding:
        """What is wrong with an attribute of an element, or with the element; the line is named."""
        line = f" (line {element.sourceline})" if element.sourceline else ""
        return Finding(called(element), attribute, f"{message}{line}")


def read(path: Path) -> ModelDocument | None:
    """The document in a file; None where the file is no XML (see `broken_text`)."""
    try:
        root = parse(content(path, LARGEST_TEXT))
    except Malformed:
        return None
    included: dict[Element, Path] = {}
    language = ROOTS.get(tag(root))
    broken = _include(root, path, included) if language == "mjcf" else []
    return ModelDocument(path, root, language, included, tuple(broken))


def broken_text(path: Path) -> Finding | None:
    """Why a file is no XML."""
    try:
        parse(content(path, LARGEST_TEXT))
    except Malformed as error:
        return Finding("XML", "", error.place)
    return None


def called(element: Element) -> str:
    """An element by tag and name, as `joint "elbow"`; one without a name also by what it is in."""
    own = tag(element)
    name = name_of(element)
    if name:
        return named(own, name)
    if own == "mesh" and element.get("file"):
        return named("mesh", stem(element))
    above = element.getparent()
    while above is not None and tag(above) in _BETWEEN:
        above = above.getparent()
    if above is None or above.getparent() is None:
        return own
    return f"{own} of {called(above)}"


_BETWEEN = ("geometry", "inertial")
"""Elements that are only around others."""


def stem(element: Element) -> str:
    """The name of an asset without one: that of its file, without folder and ending."""
    return str(element.get("file", "")).replace("\\", "/").rpartition("/")[2].rpartition(".")[0]


def sentence(findings: tuple[Finding, ...]) -> str:
    """The first findings in one line."""
    shown = [
        f"{one.element}{f' {one.attribute}' if one.attribute else ''}: {one.message}"
        for one in findings[:SHOWN]
    ]
    more = len(findings) - len(shown)
    return "; ".join(shown) + (f"; and {count(more, 'other')}" if more else "")


def _include(root: Element, path: Path, included: dict[Element, Path]) -> list[Finding]:
    """Puts the elements of included files in the place of each <include>; paths count from the model's own
    folder. Gives what cannot be included."""
    seen, found = {path.resolve()}, []

    def refused(node: Element, why: str) -> Element | None:
        found.append(Finding("include", "file", f'"{node.get("file", "")}" {why}'))
        return None

    def read(node: Element) -> Element | None:
        wanted = node.get("file", "")
        place = path.parent / wanted
        line = f"(line {node.sourceline})"
        if not wanted or not is_file(place):
            return refused(node, f"does not exist {line}")
        if place.resolve() in seen or len(seen) > MOST_INCLUDES:
            return refused(node, f"is included already {line}")
        seen.add(place.resolve())
        try:
            other = parse(content(place, LARGEST_TEXT))
        except FileTooLarge:
            return refused(node, f"is longer than {LARGEST_TEXT >> 20} MB")
        except Malformed as error:
            return refused(node, f"is no XML: {error.place}")
        included.update(dict.fromkeys(other.iter(), place))
        return other

    resolve(root, read)
    return found
