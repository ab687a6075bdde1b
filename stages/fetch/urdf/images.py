"""The images that a mesh file names: they are not read, and their loss is reported."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath

from stages.formats import gltf

_OF_MATERIAL = re.compile(rb"(?mi)^[ \t]*(?:map_\w+|bump|disp|decal|norm|refl)[ \t]+([^\r\n]+)")
_OF_COLLADA = re.compile(rb"<init_from>\s*(?:<ref>)?\s*([^<]+\.\w+)\s*<")


def images(data: bytes, kind: str, companions: Mapping[str, bytes]) -> tuple[str, ...]:
    """The names of the images of a readable mesh file, sorted; `kind`: the ending of its name, `companions`:
    the files that it names. An image inside of a glTF has its own name, or is "an image in it"."""
    if kind == "obj":
        # Options come before the name, which is the last word.
        lines = [line for text in companions.values() for line in _OF_MATERIAL.findall(text)]
        return _sorted(line.split()[-1] for line in lines if line.split())
    if kind == "dae":
        return _sorted(_OF_COLLADA.findall(data))
    if kind in ("gltf", "glb"):
        return _of_gltf(data)
    return ()


def _of_gltf(data: bytes) -> tuple[str, ...]:
    try:
        records = json.loads(gltf.chunks(data)[0]).get("images", ())
        uris = [str(one.get("uri", "")) for one in records]
        names = [str(one.get("name", "")) or "an image in it" for one in records]
    except (AttributeError, TypeError, ValueError, RecursionError):
        return ()
    inside = [not uri or uri.startswith("data:") for uri in uris]
    return tuple(sorted({name if own else uri for uri, name, own in zip(uris, names, inside, strict=True)}))


def _sorted(names: Iterable[bytes]) -> tuple[str, ...]:
    """The last part of each path, once."""
    texts = {name.decode("utf-8", "replace").strip().replace("\\", "/") for name in names}
    return tuple(sorted({PurePosixPath(text).name for text in texts}))
