"""Reads the files that a mesh file names: the materials of an OBJ, the buffers of a glTF, and the images of
their materials."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from urllib.parse import unquote

from linkwright.stages.fetch.urdf.meshes import gltf_materials, obj_materials
from linkwright.stages.formats import png
from linkwright.stages.robot.system import regular_files

NAMING_FILES = (".obj", ".gltf", ".glb")
"""The endings of mesh files that name other files."""

_LARGEST = 1 << 28
"""Largest size of a file that a mesh names [bytes]."""

_LARGEST_IMAGES = 1 << 28
"""Largest total size of the images of a mesh [bytes]."""

_MAX_IMAGES = 1000
"""Largest number of images that a mesh may name."""

TOO_MANY = f"the mesh names more than {_MAX_IMAGES} images"


@dataclass(frozen=True, slots=True)
class Companions:
    """The files that a mesh file names, by its names for them."""

    files: Mapping[str, bytes] = field(default_factory=dict)
    images: Mapping[str, bytes | str] = field(default_factory=dict)
    """The content of each image that gives a material its colour, or the reason why it is not read."""


def companions(path: Path, data: bytes, roots: Sequence[Path]) -> Companions:
    """Reads the files that the mesh file `path` with the content `data` names: existing files below its
    folder, and images also below one of the `roots`, the robot's own folders."""
    kind = path.suffix.lower()
    names, images, folders = list[str](), list[str](), [path.parent]
    if kind == ".obj":
        names = obj_materials.libraries(data)
    elif kind in NAMING_FILES:
        names, images = gltf_materials.buffers(data), gltf_materials.images(data)
    contents = {name: _content([path.parent], path.parent, name, _LARGEST) for name in dict.fromkeys(names)}
    files = {name: content for name, content in contents.items() if isinstance(content, bytes)}
    if kind == ".obj" and names and names[0] in files:
        images = [
            material.image for material in obj_materials.materials(files[names[0]]).values() if material.image
        ]
        folders = [(path.parent / names[0]).parent, path.parent]
    return Companions(files, _images(dict.fromkeys(images), dict.fromkeys(folders), [path.parent, *roots]))


def _images(
    names: Iterable[str], folders: Iterable[Path], allowed_folders: Sequence[Path]
) -> dict[str, bytes | str]:
    """Reads the images of a mesh, named relative to one of the folders."""
    contents: dict[str, bytes | str] = {}
    size = 0
    for name in islice(names, _MAX_IMAGES):
        limit = min(png.MAX_BYTES, _LARGEST_IMAGES - size)
        reads = [_content(allowed_folders, folder, name, limit) for folder in folders]
        contents[name] = next((content for content in reads if isinstance(content, bytes)), reads[0])
        size += len(contents[name])
    return contents


def _content(allowed_folders: Sequence[Path], folder: Path, name: str, limit: int) -> bytes | str:
    """Returns the content of a file that is named relative to `folder`, or the reason why it is not read."""
    why = "there is no such file"
    for spelling in dict.fromkeys((name, unquote(name), name.replace("\\", "/"))):
        try:
            place = (folder / spelling).resolve()
            if not any(place.is_relative_to(root.resolve()) for root in allowed_folders):
                why = "it is outside of the robot's folders"
                continue
            return regular_files.content(place, limit)
        except regular_files.FileTooLarge as error:
            why = f"it has {error.size} bytes, more than is read"
        except (OSError, ValueError):
            continue
    return why
