"""Finds what made an engine refuse a file: the engine's message names an element or another file."""

import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from linkwright.stages.formats.xml import Element, Malformed, parse, tag
from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.findings import link, named

ATTRIBUTES_BY_WORD = (
    ("axis", "joint", "axis"),
    ("range", "joint", "range, limit"),
    ("mass and inertia", "body", "inertial mass, inertia"),
    ("mass", "body", "inertial mass"),
    ("inertia", "body", "inertial inertia"),
    ("damping", "joint", "damping"),
)
"""(word of the message, tag of the element that it refers to, attribute of the element), in the order in
which they are tried."""


def located(path: Path, message: str) -> tuple[Finding, ...]:
    """Returns the finding of a refusal. Its element is the file if nothing more is known. `message`: the
    engine's message."""
    text = " ".join(message.split())
    try:
        root = parse(path.read_bytes())
    except Malformed as error:
        return (Finding(path.name, "XML", str(error)),)
    urdf = path.suffix == ".urdf"
    for element, attribute in _places(root, text, urdf):
        return (Finding(element, attribute, text),)
    return (Finding(path.name, "", text),)


def _places(root: Element, text: str, urdf: bool) -> Iterator[tuple[str, str]]:
    """Yields (element, attribute) for each place that the message may mean, the surest first."""
    repeated = re.search(r"repeated name '([^']+)' in (\w+)", text)
    if repeated:
        kind = "link" if urdf and repeated[2] == "body" else repeated[2]
        yield named(kind, repeated[1]), "name"
    repeated_joint = re.search(r"element '([^']+)' is repeated in equality", text)
    if repeated_joint:
        yield named("joint", repeated_joint[1]), "name"
    file_match = re.search(r"[Ff]ile '([^']+)'", text)
    if file_match:
        yield from _elements_of_file(root, PurePosixPath(file_match[1]).name)
    name_match = re.search(r"Element name '([^']+)'", text)
    if name_match:
        for word, kind, attribute in ATTRIBUTES_BY_WORD:
            if word in text.lower():
                yield (link(name_match[1], urdf) if kind == "body" else named(kind, name_match[1])), attribute
        yield f'"{name_match[1]}"', ""


def _elements_of_file(root: Element, file_name: str) -> Iterator[tuple[str, str]]:
    """Yields the elements that name a file."""
    for node in root.iter():
        for attribute, value in node.attrib.items():
            if PurePosixPath(str(value)).name != file_name:
                continue
            owner = next(node.iterancestors("link"), None)
            if owner is not None:
                yield link(owner.get("name", ""), urdf=True), f"{tag(node)} {attribute}"
            else:
                yield named(tag(node), node.get("name") or file_name), str(attribute)
