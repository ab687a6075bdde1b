"""Lists the images that a mesh file names for other purposes than colours, and all images of a DAE.

These images are not read, and their loss is reported.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath

from linkwright.stages.fetch.urdf.meshes import gltf_materials, obj_materials

_DAE_IMAGE = re.compile(rb"<init_from>\s*(?:<ref>)?\s*([^<]+\.\w+)\s*<")


def images(data: bytes, kind: str, companions: Mapping[str, bytes]) -> tuple[str, ...]:
    """Returns the names of the images of a readable mesh file that are not read, sorted.

    `kind`: the ending of the file's name; `companions`: the files that it names. An image inside of a glTF
    has its own name, or is "an image in it".
    """
    if kind == "obj":
        libraries = [obj_materials.materials(text).values() for text in companions.values()]
        return _sorted(
            name for library in libraries for material in library for name in material.other_images
        )
    if kind == "dae":
        return _sorted(name.decode("utf-8", "replace").strip() for name in _DAE_IMAGE.findall(data))
    if kind in ("gltf", "glb"):
        return gltf_materials.unused_images(data)
    return ()


def _sorted(names: Iterable[str]) -> tuple[str, ...]:
    """Returns the last part of each path, once, sorted."""
    return tuple(sorted({PurePosixPath(name.replace("\\", "/")).name for name in names}))
