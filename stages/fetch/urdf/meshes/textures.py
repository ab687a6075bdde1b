"""The images that give a mesh file its colours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256

from linkwright.stages.fetch.urdf.meshes import obj_materials
from linkwright.stages.fetch.urdf.meshes.companions import TOO_MANY, Companions
from linkwright.stages.formats import png

NO_COORDINATES = "the mesh has no texture coordinates"

_JPEG = b"\xff\xd8\xff"


@dataclass(frozen=True, slots=True)
class Texture:
    """An image of a material. `name` as messages have it; `image`: a PNG, and `digest` its SHA-256; `why`:
    the reason why there is none, "" where there is one. `white`: whether the image gives the whole colour, as
    the material has none.
    """

    name: str
    image: bytes = b""
    digest: str = ""
    why: str = ""
    white: bool = False

    def without(self, why: str) -> Texture:
        """The texture without its image, for this reason."""
        return replace(self, image=b"", digest="", why=why)


def texture(name: str, content: bytes | str, *, white: bool = False) -> Texture:
    """The texture of an image file with this content, or with the reason why there is none."""
    name = name.replace("\\", "/").rpartition("/")[2]
    if isinstance(content, str):
        return Texture(name, why=content)
    if len(content) > png.LARGEST:
        return Texture(name, why=f"it has {len(content)} bytes, more than is read")
    if content.startswith(_JPEG):
        return Texture(name, why="it is a JPEG, and only PNG images are carried")
    why = png.problem(content)
    return Texture(name, why=why) if why else Texture(name, content, sha256(content).hexdigest(), "", white)


def of_obj(beside: Companions) -> dict[str, Texture]:
    """The textures of an OBJ's materials, by the names of these."""
    found: dict[str, Texture] = {}
    for library in beside.files.values():
        for name, material in obj_materials.materials(library).items():
            if material.options:
                why = f"its options ({material.options}) are not supported"
                found.setdefault(name, texture(material.image, why))
            elif material.image:
                content = beside.images.get(material.image, TOO_MANY)
                found.setdefault(name, texture(material.image, content, white=not material.has_colour))
    return found


def of_gltf(images: Mapping[str, tuple[str, bytes | str]]) -> dict[str, Texture]:
    """The textures of a glTF's materials, by the names of these; `images`: their names and contents."""
    made = {pair: texture(*pair) for pair in dict.fromkeys(images.values())}
    return {material: made[pair] for material, pair in images.items()}
