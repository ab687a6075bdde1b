"""Names and collects the image files of textured meshes, and the MTL files of their OBJ files."""

from collections.abc import Iterable

from linkwright.stages.mesh.files import obj
from linkwright.stages.mesh.visuals.make import LinkVisuals
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.model.geometry import NEUTRAL, Shape

IMAGE_SUFFIX = ".png"


def image_name(digest: str) -> str:
    """Returns an image's file name, made from its SHA-256, so that meshes share the files of equal images."""
    return f"texture_{digest[:16]}{IMAGE_SUFFIX}"


def images(links: Iterable[LinkVisuals], bundle: Bundle) -> dict[str, bytes]:
    """Returns the images of all visual meshes, by file name."""
    digests = {file.texture for link in links for file in link.files if file.texture}
    return {image_name(digest): bundle.body(digest) for digest in sorted(digests)}


def with_material_files(shape: Shape, file: str, data: bytes) -> dict[str, bytes]:
    """Returns the OBJ `file` of a textured shape, and the MTL file that holds its material, by name."""
    assert shape.texture is not None
    stem = file.removesuffix(".obj")
    material = shape.texture.removesuffix(IMAGE_SUFFIX)
    return {
        file: obj.with_material(data, f"{stem}.mtl", material),
        f"{stem}.mtl": obj.write_material(material, shape.colour or NEUTRAL, shape.texture),
    }
