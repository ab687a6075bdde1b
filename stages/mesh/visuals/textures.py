"""The images of textured meshes, and what their OBJ files need beside them."""

from collections.abc import Iterable

from linkwright.stages.mesh.files import obj
from linkwright.stages.mesh.visuals.make import LinkVisuals
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.model.geometry import NEUTRAL, Shape

IMAGE = ".png"


def name(digest: str) -> str:
    """The name of an image's file by its SHA-256: the same image is one file, however many meshes have it."""
    return f"texture_{digest[:16]}{IMAGE}"


def images(links: Iterable[LinkVisuals], bundle: Bundle) -> dict[str, bytes]:
    """The images of all visual meshes, by name."""
    digests = {file.texture for link in links for file in link.files if file.texture}
    return {name(digest): bundle.body(digest) for digest in sorted(digests)}


def dressed(shape: Shape, file: str, data: bytes) -> dict[str, bytes]:
    """The OBJ `file` of a textured shape, and the library with its material, by name."""
    assert shape.texture is not None
    stem = file.removesuffix(".obj")
    material = shape.texture.removesuffix(IMAGE)
    return {
        file: obj.with_material(data, f"{stem}.mtl", material),
        f"{stem}.mtl": obj.library(material, shape.colour or NEUTRAL, shape.texture),
    }
