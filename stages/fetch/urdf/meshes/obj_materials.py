"""Reads the materials of an OBJ: finds the names of its MTL files, and parses these with their images."""

from __future__ import annotations

import re
from dataclasses import dataclass

_LIBRARY = re.compile(rb"^mtllib[ \t]+([^\r\n]+)", re.MULTILINE)
_OTHER_TEXTURE = re.compile(r"(?:map_\w+|bump|disp|decal|norm|refl)", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class ObjMaterial:
    """A material of an MTL file."""

    image: str = ""
    """The file name of the colour texture (map_Kd), or ""."""

    options: str = ""
    """The options of the colour texture."""

    has_colour: bool = False
    """Whether the material sets a diffuse colour (Kd)."""

    other_images: tuple[str, ...] = ()
    """The file names of the other textures, such as bump maps."""


def libraries(data: bytes) -> list[str]:
    """Returns the names of the MTL files that an OBJ refers to, each once, in order."""
    names = (name.decode("utf-8", "replace").strip() for name in _LIBRARY.findall(data))
    return list(dict.fromkeys(names))


def materials(library: bytes) -> dict[str, ObjMaterial]:
    """Parses an MTL file; returns its materials by name."""
    lines_by_name: dict[str, list[list[str]]] = {}
    lines: list[list[str]] = []
    for line in _text(library).splitlines():
        fields = line.split(maxsplit=1)
        if len(fields) < 2:
            continue
        if fields[0].lower() == "newmtl":
            lines = lines_by_name[" ".join(fields[1].split())] = []
        else:
            lines.append(fields)
    return {name: _material(material_lines) for name, material_lines in lines_by_name.items()}


def _material(lines: list[list[str]]) -> ObjMaterial:
    image = options = ""
    other_images = []
    has_colour = False
    for keyword, value in lines:
        if keyword.lower() == "map_kd":
            # With options the file name is the last word; without options it may contain spaces.
            options, _, image = value.rpartition(" ") if value.startswith("-") else ("", "", value.strip())
        elif _OTHER_TEXTURE.fullmatch(keyword):
            other_images.append(value.split()[-1])
        has_colour |= keyword.lower() == "kd"
    return ObjMaterial(image, options, has_colour, tuple(other_images))


def _text(data: bytes) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1")
