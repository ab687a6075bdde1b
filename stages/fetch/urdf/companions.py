"""The files that a mesh file names: an OBJ's materials, a glTF's buffers."""

from __future__ import annotations

import json
import re
from pathlib import Path
from urllib.parse import unquote

from stages.fetch import regular_files

_LARGEST = 1 << 28


def companions(path: Path, data: bytes) -> dict[str, bytes]:
    """The files that the mesh file `path` with the content `data` names, by these names: existing files below
    its folder, without images."""
    kind = path.suffix.lower()
    names: list[str] = []
    if kind == ".obj":
        found = re.findall(rb"^mtllib[ \t]+([^\r\n]+)", data, re.MULTILINE)
        names = [name.decode("utf-8", "replace").strip() for name in found]
    elif kind == ".gltf":
        names = _buffers(data)
    read = {name: _content(path.parent, name) for name in dict.fromkeys(names)}
    return {name: content for name, content in read.items() if content is not None}


def _buffers(data: bytes) -> list[str]:
    try:
        buffers = json.loads(data).get("buffers", ())
        uris = [buffer.get("uri") for buffer in buffers]
    except (AttributeError, TypeError, ValueError, RecursionError):
        return []
    return [uri for uri in uris if isinstance(uri, str) and not uri.startswith("data:")]


def _content(folder: Path, name: str) -> bytes | None:
    for spelt in dict.fromkeys((name, unquote(name), name.replace("\\", "/"))):
        try:
            place = (folder / spelt).resolve()
            if place.is_relative_to(folder.resolve()):
                return regular_files.content(place, _LARGEST)
        except (OSError, ValueError, regular_files.FileTooLarge):
            continue
    return None
