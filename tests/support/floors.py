"""The floors of the product as a picture: `python -m tests.support.floors` writes `docs/floors.svg`.

Drawn from the import graph: the rooms of each floor, and an arrow from each floor to each that it imports.
"""

from html import escape
from pathlib import Path

from tests.support.imports import imports
from tests.support.places import PROJECT

PICTURE = PROJECT / "docs" / "floors.svg"

FLOORS = (
    ("pipeline", ("pipeline",), "how a build runs: configuration, cache, documents; knows no robotics"),
    (
        "stages",
        ("stages.fetch", "stages.graph", "stages.mesh", "stages.export", "stages.validate"),
        "what a build does: five stages, none of which imports another",
    ),
    ("stages.show", ("stages.show",), "what is shown of a robot: live view, picture, tree"),
    ("stages.mujoco", ("stages.mujoco",), "compiles a model, and asks it"),
    ("stages.formats", ("stages.formats",), "text ↔ value: URDF, MJCF, SDF, robot.json, meshes"),
    ("stages.targets", ("stages.targets",), "what engines take of a robot, in one table"),
    ("stages.robot", ("stages.robot",), "the value that the stages hand on, and its mechanics"),
)
"""Name, packages and purpose of each floor, from the top."""

WIDTH, MARGIN, GAP = 980, 20, 34
LANES = 130
"""Space beside the floors for the arrows that pass a floor by."""

HEAD, LINE = 46, 15
LETTER = 6.3
"""Width of a letter of a room's name."""


def rooms(package):
    """The rooms of a package: its folders, or its modules where it has no folders."""
    folder = PROJECT / package.replace(".", "/")
    folders = sorted(path.parent.name for path in folder.glob("*/__init__.py"))
    return folders or sorted(path.stem for path in folder.glob("*.py") if path.stem != "__init__")


def floor_of(module):
    """The name of the floor that a module lies on; "" for `conf`."""
    for name, packages, _ in FLOORS:
        if f"{module}.".startswith(tuple(f"{package}." for package in packages)):
            return name
    return ""


def picture():
    """The SVG."""
    right = WIDTH - MARGIN - LANES
    top, parts, places = MARGIN, [], {}
    for name, packages, purpose in FLOORS:
        height, drawn = _floor(name, packages, purpose, top, right)
        parts += drawn
        places[name] = (top, height)
        top += height + GAP
    between = {(floor_of(importer), floor_of(target)) for importer, target in imports().edges}
    lane = right
    for number, (name, _, _) in enumerate(FLOORS):
        for step, (other, _, _) in enumerate(FLOORS[number + 1 :]):
            if (name, other) not in between:
                continue
            begin, end = sum(places[name]), places[other][0]
            if step == 0:
                path = f"M{(MARGIN + right) / 2:.0f} {begin}V{end - 2}"
            else:
                lane += 12
                path = f"M{right} {begin - 12 - 8 * step}H{lane}V{end + 8 + 9 * number}H{right + 2}"
            parts.append(
                f'<path d="{path}" fill="none" stroke="#446" stroke-width="1.5" marker-end="url(#tip)"/>'
            )
    height = top - GAP + MARGIN
    head = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif">',
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
        'orient="auto"><path d="M0 0L8 4L0 8z" fill="#446"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>',
    ]
    return "\n".join([*head, *parts, "</svg>", ""])


def _floor(name, packages, purpose, top, right):
    """The height of a floor, and its elements."""
    share = (right - MARGIN - 12) / len(packages)
    titles = len(packages) > 1
    lists = {package: _lines(rooms(package), int((share - 24) / LETTER)) for package in packages}
    most = max(len(lines) for lines in lists.values()) + titles
    height = HEAD + LINE * most + 18
    parts = [
        f'<rect x="{MARGIN}" y="{top}" width="{right - MARGIN}" height="{height}" rx="8" '
        'fill="#eef2f8" stroke="#446"/>',
        _text(MARGIN + 14, top + 24, 16, name, ' font-weight="bold"'),
        _text(MARGIN + 170, top + 24, 13, purpose, ' fill="#444"'),
    ]
    for number, (package, lines) in enumerate(lists.items()):
        left = MARGIN + 10 + number * share
        parts.append(
            f'<rect x="{left:.0f}" y="{top + 36}" width="{share - 8:.0f}" height="{LINE * most + 16}" rx="5" '
            'fill="#fff" stroke="#9ab"/>'
        )
        y = top + 54
        if titles:
            parts.append(_text(left + 8, y, 13, package.rpartition(".")[2], ' font-weight="bold"'))
            y += LINE
        for text in lines:
            parts.append(_text(left + 8, y, 11.5, text, ' fill="#222"'))
            y += LINE
    return height, parts


def _text(x, y, size, text, look):
    return f'<text x="{x:.0f}" y="{y}" font-size="{size}"{look}>{escape(text)}</text>'


def _lines(words, most):
    """The words in lines of at most so many letters."""
    lines = [""]
    for word in words:
        longer = f"{lines[-1]} · {word}" if lines[-1] else word
        if len(longer) > most and lines[-1]:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


if __name__ == "__main__":
    Path(PICTURE).write_text(picture(), encoding="utf-8")
