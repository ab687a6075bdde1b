"""Reads the facts of XML. The name of a material is not a fact, but its place in the order of materials
is."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

from linkwright.stages.formats.xml import Element, Malformed, parse, tag
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.rewritten.facts import Place, Turn, Unparsable, Value, words

IDENTIFYING_ATTRIBUTES = ("link1", "link2", "filename", "file")
"""Attributes, in addition to `name`, that tell an element from siblings with its tag."""

WHOLE_ELEMENTS = ('joint "', 'link "', 'sensor "')
"""Elements whose named parts are shown as parts of them."""

TENSOR_ATTRIBUTES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""Attributes that are compared as a single value, the tensor."""

LENGTH_ATTRIBUTES = ("xyz", "offset", "lower", "upper")
"""Attributes in metres or radians, whose differences are absolute for numbers below 1."""

LENGTH_ELEMENTS = ("param",)
"""Elements of ros2_control whose text is a length or an angle."""


def xml_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    """Yields the facts of an XML file; raises Unparsable."""
    try:
        root = parse(data, large=True)
    except Malformed as error:
        raise Unparsable(f"is not XML: {error.place}") from None
    materials = {name: f"material {number}" for number, name in enumerate(_materials(root), 1)}
    yield from _facts(root, Place((tag(root),), tag(root), ""), materials)


def _materials(root: Element) -> list[str]:
    """Returns the names of materials, in the order of the file."""
    names = (
        node.get(key)
        for node in root.iter("*")
        for key in (("material", "name") if tag(node) == "material" else ("material",))
    )
    return list(dict.fromkeys(filter(None, names)))


def _facts(node: Element, place: Place, materials: dict[str, str]) -> Iterator[tuple[Place, Value]]:
    yield replace(place, path=(*place.path, "")), True
    for key, value in _attributes(node, materials):
        yield _place_within(place, f"@{key}", key), value
    children = [child for child in node if isinstance(child.tag, str)]
    text = " ".join(" ".join(node.xpath("text()")).split())
    if text and not children:
        least = 1.0 if tag(node) in LENGTH_ELEMENTS else 0.0
        yield replace(_place_within(place, "text", ""), least=least), words(text)
    key_counts: Counter[str] = Counter()
    tags = Counter(map(tag, children))
    for child in children:
        key = _key(child, tags[tag(child)] > 1)
        key_counts[key] += 1
        yield from _facts(child, _place_of_child(place, child, key, key_counts[key]), materials)


def _attributes(node: Element, materials: dict[str, str]) -> Iterator[tuple[str, Value]]:
    tensor = tuple(words(node.get(key, "")) for key in TENSOR_ATTRIBUTES if key in node.attrib)
    if tensor:
        yield "tensor", tuple(row[0] if isinstance(row, tuple) else row for row in tensor)
    for key, text in node.attrib.items():
        value = words(text)
        if text and (key == "material" or (key == "name" and tag(node) == "material")):
            yield key, materials[text]
        elif key == "rpy" and isinstance(value, tuple) and len(value) == 3:
            roll, pitch, yaw = (float(str(angle)) for angle in value)
            yield key, Turn((roll, pitch, yaw))
        elif key not in TENSOR_ATTRIBUTES:
            yield key, value


def _key(node: Element, repeats: bool) -> str:
    """Returns the key that tells an element from its siblings, unless they have the same content."""
    keys = ("name", *IDENTIFYING_ATTRIBUTES) if repeats else ("name",)
    values = [f"{key}={node.get(key)}" for key in keys if node.get(key) and tag(node) != "material"]
    if not values and repeats and not len(node):
        values = [" ".join((node.text or "").split())]
    return " ".join((tag(node), *values))


def _place_of_child(place: Place, node: Element, key: str, number: int) -> Place:
    """Returns the place of a child. A child with a name is an element, except in a joint or a link; any other
    child is a part of the element above."""
    path = (*place.path, f"{key} {number}")
    name = node.get("name") if tag(node) != "material" else None
    if name and not place.element.startswith(WHOLE_ELEMENTS):
        return Place(path, named(tag(node), name), "")
    links = node.get("link1"), node.get("link2")
    if all(links):
        return Place(path, named(tag(node), '" "'.join(map(str, links))), "")
    part_title = named(tag(node), name) if name else tag(node) if number == 1 else f"{tag(node)} {number}"
    return Place(path, place.element, f"{place.attribute} {part_title}".strip())


def _place_within(place: Place, key: str, attribute: str) -> Place:
    """Returns the place of an attribute or of the text of an element."""
    least = 1.0 if attribute in LENGTH_ATTRIBUTES else 0.0
    return Place((*place.path, key), place.element, f"{place.attribute} {attribute}".strip(), least)
