"""The visuals and collisions of an SDF's links."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from linkwright.stages.formats.sdf.elements import SdfError, bound, needed, numbers, pose_of, truth
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.model.geometry import Colour
from linkwright.stages.robot.model.robot import Array, frozen

SIZES = {"box": (("size", 3),), "sphere": (("radius", 1),)} | dict.fromkeys(
    ("cylinder", "capsule"), (("radius", 1), ("length", 1))
)
"""The elements that have a primitive's size, and how many numbers each has."""


@dataclass(frozen=True, slots=True, eq=False)
class SdfShape:
    """A visual or a collision.

    `kind`: the element in its <geometry>, "" for none; `size` [m] as in `model.Primitive`, () of what is no
    primitive; `filename`: the <uri> of a mesh, as the file has it; `link_from_shape` (4, 4). Of a visual:
    `colour` and `ambient`: its material's RGBA in the light and in the shade, None where the file gives none,
    and `transparency`, 0 for none; `texture`: "", since images come with meshes. Of a collision: `friction`:
    the coefficients `mu` and `mu2`, None where the file gives none; `mask`: the bits of which it shares one
    with what it collides with, None where the file gives none; `pushed`: whether contacts push it.
    """

    name: str
    kind: str
    size: tuple[float, ...]
    filename: str
    scale: tuple[float, ...]
    link_from_shape: Array
    colour: Colour | None
    ambient: Colour | None
    transparency: float
    friction: tuple[float | None, float | None]
    mask: int | None
    pushed: bool
    texture: str = ""


def shapes_of(link: Element, role: str, link_from: Callable[[str], Array]) -> tuple[SdfShape, ...]:
    """Those of a link that are a `visual`, or a `collision`, in the order of the file. `link_from`: the pose
    (4, 4) in the link of what a name stands for. SdfError where a number is none, or is missing."""
    return tuple(_shape(node, link_from) for node in link.findall(role))


def _shape(node: Element, link_from: Callable[[str], Array]) -> SdfShape:
    pose = node.find("pose")
    above = pose.get("relative_to") if pose is not None else None
    place = (link_from(above) if above else np.eye(4)) @ pose_of(pose)
    held = [one for one in needed(node, "geometry") if isinstance(one.tag, str)]
    geometry = held[0] if held else None
    kind = "" if geometry is None else tag(geometry)
    size: list[float] = []
    filename, scale = "", [1.0, 1.0, 1.0]
    if geometry is not None and kind == "mesh":
        filename = (needed(geometry, "uri").text or "").strip()
        given = geometry.find("scale")
        scale = scale if given is None else numbers(given, 3)
    elif geometry is not None:
        for path, count in SIZES.get(kind, ()):
            size += numbers(needed(geometry, path), count)
    mu, mu2 = (bound(node, f"surface/friction/ode/{key}") for key in ("mu", "mu2"))
    return SdfShape(
        str(node.get("name")),
        kind,
        tuple(size),
        filename,
        tuple(scale),
        frozen(place),
        _colour(node, "diffuse"),
        _colour(node, "ambient"),
        bound(node, "transparency") or 0.0,
        (mu, mu2),
        _mask(node),
        not truth(node, "surface/contact/collide_without_contact", unless=False),
    )


def _colour(node: Element, key: str) -> Colour | None:
    given = node.find(f"material/{key}")
    if given is None:
        return None
    # Alpha may be left out.
    red, green, blue, *alpha = numbers(given, 4 if len((given.text or "").split()) == 4 else 3)
    return red, green, blue, alpha[0] if alpha else 1.0


def _mask(node: Element) -> int | None:
    text = (node.findtext("surface/contact/collide_bitmask") or "").strip()
    try:
        return int(text, 0) if text else None
    except ValueError:
        raise SdfError(f"<collide_bitmask> is no whole number: {text!r}") from None
