"""Reads a model file as XML, with the files that it includes, and names its elements in findings."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from linkwright.stages.formats.mjcf.bounds import MAX_XML_BYTES
from linkwright.stages.formats.own_xml import name_of
from linkwright.stages.formats.xml import Element, Malformed, parse, tag
from linkwright.stages.mujoco.includes import replace_includes
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.system.regular_files import FileTooLarge, content, is_file
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import named

Language = Literal["urdf", "mjcf"]

ROOTS: dict[str, Language] = {"robot": "urdf", "mujoco": "mjcf"}
"""The root elements of models, with their languages."""

MAKERS = frozenset(["attach", "replicate", "composite", "flexcomp", "flex", "plugin", "model"])
"""Elements of an MJCF that make other elements, with names and joints that are not in the text."""

MAX_LISTED = 3
"""Largest number of findings that a check's detail lists."""

MAX_INCLUDES = 100
"""Largest number of files that a model may include."""


@dataclass(frozen=True, slots=True, eq=False)
class ModelDocument:
    """A model file as XML."""

    path: Path
    root: Element
    """The root of the model, with the elements of the files that it includes."""

    language: Language | None
    """None if the root element is not that of a model."""

    included: dict[Element, Path]
    """Element of an included file → the file."""

    broken: tuple[Finding, ...] = ()
    """Findings on parts of the text that cannot be read."""

    packages: tuple[str, ...] | None = None
    """The names of the packages whose root is the file's folder; None if unknown."""

    foreign: bool = False
    """Whether another program wrote the file."""

    def elements(self) -> Iterator[Element]:
        """Returns the elements of this file, without included files, in their order."""
        return (element for element in self.root.iter() if element not in self.included)

    def finding(self, element: Element, attribute: str, message: str) -> Finding:
        """Returns a finding on an attribute of an element, or on the element, with its line."""
        line = f" (line {element.sourceline})" if element.sourceline else ""
        return Finding(title_of(element), attribute, f"{message}{line}")


def read(path: Path) -> ModelDocument | None:
    """Reads the document in a file; None if the file is not XML (see `broken_text`)."""
    try:
        root = parse(content(path, MAX_XML_BYTES))
    except Malformed:
        return None
    included: dict[Element, Path] = {}
    language = ROOTS.get(tag(root))
    broken = _include(root, path, included) if language == "mjcf" else []
    return ModelDocument(path, root, language, included, tuple(broken))


def broken_text(path: Path) -> Finding | None:
    """Returns the finding that says why a file is not XML; None if it is XML."""
    try:
        parse(content(path, MAX_XML_BYTES))
    except Malformed as error:
        return Finding("XML", "", error.place)
    return None


def title_of(element: Element) -> str:
    """Returns an element's title, such as `joint "elbow"`. The title of an element without a name has its tag
    and the title of its parent."""
    name_of_tag = tag(element)
    name = name_of(element)
    if name:
        return named(name_of_tag, name)
    if name_of_tag == "mesh" and element.get("file"):
        return named("mesh", stem(element))
    parent = element.getparent()
    while parent is not None and tag(parent) in _GROUPS:
        parent = parent.getparent()
    if parent is None or parent.getparent() is None:
        return name_of_tag
    return f"{name_of_tag} of {title_of(parent)}"


_GROUPS = ("geometry", "inertial")
"""Elements that only group other elements."""


def stem(element: Element) -> str:
    """Returns the name of an unnamed asset: the name of its file, without folder and ending."""
    return str(element.get("file", "")).replace("\\", "/").rpartition("/")[2].rpartition(".")[0]


def sentence(findings: tuple[Finding, ...]) -> str:
    """Returns the first findings in a single line of text."""
    shown = [
        f"{finding.element}{f' {finding.attribute}' if finding.attribute else ''}: {finding.message}"
        for finding in findings[:MAX_LISTED]
    ]
    others_count = len(findings) - len(shown)
    return "; ".join(shown) + (f"; and {count(others_count, 'other')}" if others_count else "")


def _include(root: Element, path: Path, included: dict[Element, Path]) -> list[Finding]:
    """Replaces each <include> by the elements of its file; paths count from the model's own folder. Returns
    findings of files that cannot be included."""
    visited, findings = {path.resolve()}, []

    def refused(node: Element, why: str) -> Element | None:
        findings.append(Finding("include", "file", f'"{node.get("file", "")}" {why}'))
        return None

    def included_root(node: Element) -> Element | None:
        name = node.get("file", "")
        place = path.parent / name
        line = f"(line {node.sourceline})"
        if not name or not is_file(place):
            return refused(node, f"does not exist {line}")
        if place.resolve() in visited or len(visited) > MAX_INCLUDES:
            return refused(node, f"is included already {line}")
        visited.add(place.resolve())
        try:
            root_of_file = parse(content(place, MAX_XML_BYTES))
        except FileTooLarge:
            return refused(node, f"is longer than {MAX_XML_BYTES >> 20} MB")
        except Malformed as error:
            return refused(node, f"is not XML: {error.place}")
        included.update(dict.fromkeys(root_of_file.iter(), place))
        return root_of_file

    replace_includes(root, included_root)
    return findings
