"""Edits of elements, numbers and texts, of which the tables of faults are made."""

import random
import re
from collections.abc import Callable, Sequence
from pathlib import Path

from lxml import etree

from tests.support.faults.arm import replace_last
from tests.support.faults.fault import Element, Files, Names, NothingToChange, Plant, Planted

Draw = Callable[[random.Random], str]
Change = Callable[[Element, random.Random], Names | Planted | None]
"""Changes an element, and returns what a finding names if that is not its name."""

Values = Callable[[list[float], random.Random], Sequence[float]]


def pick(elements: Sequence[Element], rng: random.Random) -> Element:
    if not elements:
        raise NothingToChange
    return rng.choice(list(elements))


def named(tag: str, node: Element) -> str:
    return f'{tag} "{node.get("name")}"'


def holder(node: Element) -> str:
    """The name of an element, or of the nearest above it that has a name; shapes are named by their links."""
    while node.get("name") is None or node.tag in ("visual", "collision"):
        node = node.getparent()
    return named(node.tag, node)


def at(
    path: str,
    *changes: Change,
    where: Callable[[Element], bool] | None = None,
    names: Callable[[Element], Names] = holder,
) -> Plant:
    """Changes one of the elements on this path, of those for which `where` holds. A finding names `names`."""

    def plant(files: Files, rng: random.Random) -> Names | Planted:
        nodes = files.root.xpath(path)
        node = pick([it for it in nodes if where(it)] if where else nodes, rng)
        expected: Names | Planted = names(node)
        for change in changes:
            expected = change(node, rng) or expected
        return expected

    return plant


def all_of(path: str, change: Change, *elements: str) -> Plant:
    """Changes the first element on this path; a finding names one of `elements`."""

    def plant(files: Files, rng: random.Random) -> Names | Planted:
        nodes = files.root.xpath(path)
        if not nodes:
            raise NothingToChange
        return change(nodes[0], rng) or elements

    return plant


def draw(low: float, high: float, digits: int = 6) -> Draw:
    return lambda rng: f"{rng.uniform(low, high):.{digits}g}"


def either(*texts: str) -> Draw:
    return lambda rng: rng.choice(texts)


def put(**values: str | Draw) -> Change:
    """Sets attributes; `class_` sets `class`."""

    def change(node: Element, rng: random.Random) -> None:
        for key, value in values.items():
            node.set(key.removesuffix("_"), value if isinstance(value, str) else value(rng))

    return change


def drop(*keys: str) -> Change:
    def change(node: Element, rng: random.Random) -> None:
        for key in keys:
            del node.attrib[key]

    return change


def swapped(first: str, second: str) -> Change:
    """Swaps two attributes."""

    def change(node: Element, rng: random.Random) -> None:
        node.attrib.update({first: node.get(second), second: node.get(first)})

    return change


def remove(node: Element, rng: random.Random) -> None:
    node.getparent().remove(node)


def add(tag: str, **attributes: str | Draw) -> Change:
    """Adds an element at the end of another."""

    def change(node: Element, rng: random.Random) -> None:
        put(**attributes)(etree.SubElement(node, tag), rng)

    return change


def numbers(node: Element, key: str, default: str = "") -> list[float]:
    return [float(word) for word in node.get(key, default).split()]


def write(node: Element, key: str, values: Sequence[float], digits: int = 15) -> None:
    node.set(key, " ".join(f"{value:.{digits}g}" for value in values))


def of(key: str, values: Values, default: str = "", digits: int = 15) -> Change:
    """Other numbers in an attribute."""

    def change(node: Element, rng: random.Random) -> None:
        write(node, key, values(numbers(node, key, default), rng), digits)

    return change


def times(key: str, *factors: float, digits: int = 12, default: str = "") -> Change:
    """The numbers of an attribute multiplied by a factor, or by one of several."""

    def scaled(values: list[float], rng: random.Random) -> list[float]:
        factor = rng.choice(factors) if len(factors) > 1 else factors[0]
        return [value * factor for value in values]

    return of(key, scaled, default, digits)


def turned_round(values: list[float], rng: random.Random) -> list[float]:
    return [0.0 - value for value in values]


def moved(key: str, low: float, high: float = 0.0) -> Change:
    """A vector moved along one axis by `low`, or by a length up to `high`."""

    def change(values: list[float], rng: random.Random) -> list[float]:
        distance = rng.uniform(low, high) if high else low
        axis = rng.randrange(3)
        values[axis] += rng.choice((-1, 1)) * distance
        return values

    return of(key, change, "0 0 0")


def text(file: str, pattern: str, new: str, element: str) -> Plant:
    """In the file of this pattern of paths: the group `old` of one of the places that match becomes `new`. A
    finding names `element`, which may have other groups in braces."""

    def plant(files: Files, rng: random.Random) -> str:
        path = rng.choice(sorted(files.folder.glob(file)) or [files.folder])
        places = list(re.finditer(pattern, path.read_text(encoding="utf-8"))) if path.is_file() else []
        if not places:
            raise NothingToChange
        place = rng.choice(places)
        (start, end), whole = place.span("old"), place.string
        path.write_text(whole[:start] + new + whole[end:], encoding="utf-8")
        return element.format(**place.groupdict())

    return plant


def swap(old: str, new: str, element: str) -> Plant:
    """Replaces the last place of a text, that of the last link or joint. A finding names `element`."""

    def plant(files: Files, rng: random.Random) -> str:
        replace_last(files.path, old, new)
        return element

    return plant


def sub(pattern: str, new: str, *, inside: str = "", count: int = 1) -> Plant:
    """Replaces what matches in the text of the file, or of the first place that matches `inside`."""

    def plant(files: Files, rng: random.Random) -> str:
        before = files.path.read_text(encoding="utf-8")
        part = re.search(inside, before, re.DOTALL)[0] if inside else before
        after = before.replace(part, re.sub(pattern, new, part, count=count, flags=re.DOTALL), 1)
        assert after != before, pattern
        files.path.write_text(after, encoding="utf-8")
        return ""

    return plant


def broken(files: Files, rng: random.Random) -> str:
    """Takes the end of an element away."""
    whole = files.path.read_bytes()
    end = rng.choice([match.start() for match in re.finditer(rb"/>", whole)])
    files.path.write_bytes(whole[:end] + whole[end + 1 :])
    return ""


def file_of(folder: Path, pattern: str, rng: random.Random) -> Path:
    """One of the files of a pattern of paths."""
    paths = sorted(folder.glob(pattern))
    if not paths:
        raise NothingToChange
    return rng.choice(paths)
