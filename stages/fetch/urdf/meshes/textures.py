"""Reads the images that give a mesh file its colours."""

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
    """The colour image of a material."""

    name: str
    """The name of the image in messages."""

    image: bytes = b""
    """The image as a PNG; b"" if it is missing."""

    digest: str = ""
    """The SHA-256 of the PNG."""

    why: str = ""
    """The reason why the image is missing, or ""."""

    white: bool = False
    """Whether the image is shown unchanged, since the material has no colour."""

    def without(self, why: str) -> Texture:
        """Returns the texture without its image, for this reason."""
        return replace(self, image=b"", digest="", why=why)


def texture(name: str, content: bytes | str, *, white: bool = False) -> Texture:
    """Returns the texture of an image file with this content, or with the reason why the content is
    missing."""
    name = name.replace("\\", "/").rpartition("/")[2]
    if isinstance(content, str):
        return Texture(name, why=content)
    if len(content) > png.MAX_BYTES:
        return Texture(name, why=f"it has {len(content)} bytes, more than is read")
    if content.startswith(_JPEG):
        return Texture(name, why="it is a JPEG, and only PNG images are carried")
    why = png.problem(content)
    return Texture(name, why=why) if why else Texture(name, content, sha256(content).hexdigest(), "", white)


def obj_textures(companions: Companions) -> dict[str, Texture]:
    """Returns the textures of an OBJ's materials, by the materials' names."""
    textures: dict[str, Texture] = {}
    for library in companions.files.values():
        for name, material in obj_materials.materials(library).items():
            if material.options:
                why = f"its options ({material.options}) are not supported"
                textures.setdefault(name, texture(material.image, why))
            elif material.image:
                content = companions.images.get(material.image, TOO_MANY)
                textures.setdefault(name, texture(material.image, content, white=not material.has_colour))
    return textures


def gltf_textures(images: Mapping[str, tuple[str, bytes | str]]) -> dict[str, Texture]:
    """Returns the textures of a glTF's materials, by the materials' names; `images`: the names and contents
    of the images."""
    texture_of = {pair: texture(*pair) for pair in dict.fromkeys(images.values())}
    return {material: texture_of[pair] for material, pair in images.items()}
