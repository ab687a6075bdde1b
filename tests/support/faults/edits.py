"""Edits of elements, numbers and texts, of which the tables of faults are made."""

import re

from lxml import etree

from tests.support.faults.arm import replace_last
from tests.support.faults.fault import NothingToChange


def pick(elements, rng):
    if not elements:
        raise NothingToChange
    return rng.choice(list(elements))


def named(tag, node):
    return f'{tag} "{node.get("name")}"'


def holder(node):
    """The name of an element, or of the nearest above it that has a name; shapes are named by their links."""
    while node.get("name") is None or node.tag in ("visual", "collision"):
        node = node.getparent()
    return named(node.tag, node)


def at(
    path,
    *changes,
    where=None,
    names=holder,
):
    """Changes one of the elements on this path, of those for which `where` holds. A finding names `names`."""

    def plant(files, rng):
        nodes = files.root.xpath(path)
        node = pick([it for it in nodes if where(it)] if where else nodes, rng)
        expected = names(node)
        for change in changes:
            expected = change(node, rng) or expected
        return expected

    return plant


def all_of(path, change, *elements):
    """Changes the first element on this path; a finding names one of `elements`."""

    def plant(files, rng):
        nodes = files.root.xpath(path)
        if not nodes:
            raise NothingToChange
        return change(nodes[0], rng) or elements

    return plant


def draw(low, high, digits=6):
    return lambda rng: f"{rng.uniform(low, high):.{digits}g}"


def either(*texts):
    return lambda rng: rng.choice(texts)


def put(**values):
    """Sets attributes; `class_` sets `class`."""

    def change(node, rng):
        for key, value in values.items():
            node.set(key.removesuffix("_"), value if isinstance(value, str) else value(rng))

    return change


def drop(*keys):
    def change(node, rng):
        for key in keys:
            del node.attrib[key]

    return change


def swapped(first, second):
    """Swaps two attributes."""

    def change(node, rng):
        node.attrib.update({first: node.get(second), second: node.get(first)})

    return change


def remove(node, rng):
    node.getparent().remove(node)


def add(tag, **attributes):
    """Adds an element at the end of another."""

    def change(node, rng):
        put(**attributes)(etree.SubElement(node, tag), rng)

    return change


def numbers(node, key, default=""):
    return [float(word) for word in node.get(key, default).split()]


def write(node, key, values, digits=15):
    node.set(key, " ".join(f"{value:.{digits}g}" for value in values))


def of(key, values, default="", digits=15):
    """Other numbers in an attribute."""

    def change(node, rng):
        write(node, key, values(numbers(node, key, default), rng), digits)

    return change


def times(key, *factors, digits=12, default=""):
    """The numbers of an attribute multiplied by a factor, or by one of several."""

    def scaled(values, rng):
        factor = rng.choice(factors) if len(factors) > 1 else factors[0]
        return [value * factor for value in values]

    return of(key, scaled, default, digits)


def turned_round(values, rng):
    return [0.0 - value for value in values]


def moved(key, low, high=0.0):
    """A vector moved along one axis by `low`, or by a length up to `high`."""

    def change(values, rng):
        distance = rng.uniform(low, high) if high else low
        axis = rng.randrange(3)
        values[axis] += rng.choice((-1, 1)) * distance
        return values

    return of(key, change, "0 0 0")


def text(file, pattern, new, element):
    """In the file of this pattern of paths: the group `old` of one of the places that match becomes `new`. A
    finding names `element`, which may have other groups in braces."""

    def plant(files, rng):
        path = rng.choice(sorted(files.folder.glob(file)) or [files.folder])
        places = list(re.finditer(pattern, path.read_text(encoding="utf-8"))) if path.is_file() else []
        if not places:
            raise NothingToChange
        place = rng.choice(places)
        (start, end), whole = place.span("old"), place.string
        path.write_text(whole[:start] + new + whole[end:], encoding="utf-8")
        return element.format(**place.groupdict())

    return plant


def swap(old, new, element):
    """Replaces the last place of a text, that of the last link or joint. A finding names `element`."""

    def plant(files, rng):
        replace_last(files.path, old, new)
        return element

    return plant


def sub(pattern, new, *, inside="", count=1):
    """Replaces what matches in the text of the file, or of the first place that matches `inside`."""

    def plant(files, rng):
        before = files.path.read_text(encoding="utf-8")
        part = re.search(inside, before, re.DOTALL)[0] if inside else before
        after = before.replace(part, re.sub(pattern, new, part, count=count, flags=re.DOTALL), 1)
        assert after != before, pattern
        files.path.write_text(after, encoding="utf-8")
        return ""

    return plant


def broken(files, rng):
    """Takes the end of an element away."""
    whole = files.path.read_bytes()
    end = rng.choice([match.start() for match in re.finditer(rb"/>", whole)])
    files.path.write_bytes(whole[:end] + whole[end + 1 :])
    return ""


def file_of(folder, pattern, rng):
    """One of the files of a pattern of paths."""
    paths = sorted(folder.glob(pattern))
    if not paths:
        raise NothingToChange
    return rng.choice(paths)
