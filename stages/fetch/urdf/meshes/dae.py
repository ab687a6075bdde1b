"""Cleans a DAE: removes images, cameras, lights, animations and incomplete materials.

None of these is used here, and trimesh silently drops each shape whose material it cannot resolve completely.
"""

from __future__ import annotations

from linkwright.stages.formats import xml
from linkwright.stages.formats.xml import Element

_WHITE = "1 1 1 1"
"""White and opaque, as a DAE writes a colour: red, green, blue and opacity."""


def cleaned(data: bytes) -> bytes:
    """Returns the document with its geometry and plain colours. Raises xml.Malformed if it is not XML."""
    root = xml.parse(data, large=True)
    for name in ("images", "cameras", "lights", "animations"):
        _remove(root.findall(f"{{*}}library_{name}"))
    for name in ("instance_camera", "instance_light", "extra", "newparam"):
        _remove(list(root.iter(f"{{*}}{name}")))
    for texture in list(root.iter("{*}texture")):
        _replace_image(texture)
    _remove_incomplete_materials(root)
    return xml.to_bytes(root)


def _replace_image(texture: Element) -> None:
    """Replaces the image of a diffuse colour by white; removes each other use of an image."""
    channel = texture.getparent()
    namespace, _, name = str(channel.tag).rpartition("}")
    if name == "diffuse":
        white = xml.element(None, f"{namespace}}}color" if namespace else "color")
        white.text = _WHITE
        channel.replace(texture, white)
    elif channel.getparent() is not None:
        channel.getparent().remove(channel)


def _remove_incomplete_materials(root: Element) -> None:
    """Removes materials without an effect, and every use of an undefined material."""
    effects = {effect.get("id") for effect in root.iter("{*}effect")}
    materials = set()
    for material in list(root.iter("{*}material")):
        effect = material.find("{*}instance_effect")
        if effect is None or effect.get("url", "").lstrip("#") not in effects:
            _remove([material])
        else:
            materials.add(material.get("id"))
    uses = list(root.iter("{*}instance_material"))
    _remove([use for use in uses if use.get("target", "").lstrip("#") not in materials])


def _remove(elements: list[Element]) -> None:
    for element in elements:
        parent = element.getparent()
        if parent is not None:
            parent.remove(element)
