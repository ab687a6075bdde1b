"""The materials of an OBJ: the libraries (MTL) that it names, and the images that these name."""

from __future__ import annotations

import re
from dataclasses import dataclass

_LIBRARY = re.compile(rb"^mtllib[ \t]+([^\r\n]+)", re.MULTILINE)
_OTHER_IMAGE = re.compile(r"(?:map_\w+|bump|disp|decal|norm|refl)", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class ObjMaterial:
    """A material: `image`: the name of the image that gives its colour, "" for none; `options`: those of the
    image; `has_colour`: whether it has a colour of its own; `others`: the names of its other images."""

    image: str = ""
    options: str = ""
    has_colour: bool = False
    others: tuple[str, ...] = ()


def libraries(data: bytes) -> list[str]:
    """The names of the libraries of an OBJ, in their order."""
    found = (name.decode("utf-8", "replace").strip() for name in _LIBRARY.findall(data))
    return list(dict.fromkeys(found))


def materials(library: bytes) -> dict[str, ObjMaterial]:
    """The materials of a library by name."""
    found: dict[str, list[list[str]]] = {}
    lines: list[list[str]] = []
    for line in _text(library).splitlines():
        words = line.split(maxsplit=1)
        if len(words) < 2:
            continue
        if words[0].lower() == "newmtl":
            lines = found[" ".join(words[1].split())] = []
        else:
            lines.append(words)
    return {name: _material(own) for name, own in found.items()}


def _material(lines: list[list[str]]) -> ObjMaterial:
    image = options = ""
    others = []
    has_colour = False
    for word, rest in lines:
        if word.lower() == "map_kd":
            # Options come before the name, which is the last word; without them it may have spaces.
            options, _, image = rest.rpartition(" ") if rest.startswith("-") else ("", "", rest.strip())
        elif _OTHER_IMAGE.fullmatch(word):
            others.append(rest.split()[-1])
        has_colour |= word.lower() == "kd"
    return ObjMaterial(image, options, has_colour, tuple(others))


def _text(data: bytes) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1")
