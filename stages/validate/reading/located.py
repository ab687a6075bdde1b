"""Finds what made an engine refuse a file: the engine's message names an element or another file."""

import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from linkwright.stages.formats.xml import Element, Malformed, parse, tag
from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.findings import link, named

WRONG = (
    ("axis", "joint", "axis"),
    ("range", "joint", "range, limit"),
    ("mass and inertia", "body", "inertial mass, inertia"),
    ("mass", "body", "inertial mass"),
    ("inertia", "body", "inertial inertia"),
    ("damping", "joint", "damping"),
)
"""A word of the message, the element that it refers to, and its attribute."""


def located(path: Path, message: str) -> tuple[Finding, ...]:
    """Returns the finding of a refusal. Its element is the file if nothing more is known."""
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
    file = re.search(r"[Ff]ile '([^']+)'", text)
    if file:
        yield from _naming(root, PurePosixPath(file[1]).name)
    name = re.search(r"Element name '([^']+)'", text)
    if name:
        for word, kind, attribute in WRONG:
            if word in text.lower():
                yield (link(name[1], urdf) if kind == "body" else named(kind, name[1])), attribute
        yield f'"{name[1]}"', ""


def _naming(root: Element, file: str) -> Iterator[tuple[str, str]]:
    """Yields the elements that name a file."""
    for node in root.iter():
        for attribute, value in node.attrib.items():
            if PurePosixPath(str(value)).name != file:
                continue
            owner = next(node.iterancestors("link"), None)
            if owner is not None:
                yield link(owner.get("name", ""), urdf=True), f"{tag(node)} {attribute}"
            else:
                yield named(tag(node), node.get("name") or file), str(attribute)
