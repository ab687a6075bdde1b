"""Reads the visuals and collisions of an SDF's links."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from linkwright.stages.formats.sdf.elements import SdfError, bound, numbers, pose_of, required_element, truth
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.model.geometry import Colour
from linkwright.stages.robot.model.robot import Array, frozen

SIZES = {"box": (("size", 3),), "sphere": (("radius", 1),)} | dict.fromkeys(
    ("cylinder", "capsule"), (("radius", 1), ("length", 1))
)
"""Kind of primitive → the elements with its size, and the number of their values."""


@dataclass(frozen=True, slots=True, eq=False)
class SdfShape:
    """A visual or a collision."""

    name: str
    kind: str
    """The element in its <geometry>, or ""."""

    size: tuple[float, ...]
    """[m], as in `model.Primitive`; () for other shapes."""

    filename: str
    """The <uri> of a mesh, as in the file."""

    scale: tuple[float, ...]
    link_from_shape: Array
    """(4, 4)."""

    colour: Colour | None
    """RGBA of a visual's material in the light; None if the file has none."""

    ambient: Colour | None
    """RGBA of a visual's material in the shade; None if the file has none."""

    transparency: float
    """Transparency of a visual: 0 for opaque."""

    friction: tuple[float | None, float | None]
    """The coefficients `mu` and `mu2` of a collision; None if the file has none."""

    mask: int | None
    """The bits of a collision: it collides with the shapes that share a bit with it. None if the file has
    none."""

    pushed: bool
    """Whether contacts push a collision."""

    texture: str = ""
    """Always "": images come with the meshes."""


def shapes_of(link: Element, role: str, link_from: Callable[[str], Array]) -> tuple[SdfShape, ...]:
    """Returns the shapes of a link that are a `visual`, or a `collision`, in the order of the file.

    `link_from`: a function from a name to its pose (4, 4) in the link. Raises SdfError if a number is missing
    or invalid.
    """
    return tuple(_shape(node, link_from) for node in link.findall(role))


def _shape(node: Element, link_from: Callable[[str], Array]) -> SdfShape:
    pose = node.find("pose")
    above = pose.get("relative_to") if pose is not None else None
    place = (link_from(above) if above else np.eye(4)) @ pose_of(pose)
    geometry = next(iter(required_element(node, "geometry")), None)
    kind = "" if geometry is None else tag(geometry)
    size: list[float] = []
    filename, scale = "", [1.0, 1.0, 1.0]
    if geometry is not None and kind == "mesh":
        filename = (required_element(geometry, "uri").text or "").strip()
        scale_node = geometry.find("scale")
        scale = scale if scale_node is None else numbers(scale_node, 3)
    elif geometry is not None:
        for path, count in SIZES.get(kind, ()):
            size += numbers(required_element(geometry, path), count)
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
    colour_node = node.find(f"material/{key}")
    if colour_node is None:
        return None
    # Alpha may be left out.
    red, green, blue, *alpha = numbers(colour_node, 4 if len((colour_node.text or "").split()) == 4 else 3)
    return red, green, blue, alpha[0] if alpha else 1.0


def _mask(node: Element) -> int | None:
    text = (node.findtext("surface/contact/collide_bitmask") or "").strip()
    try:
        return int(text, 0) if text else None
    except ValueError:
        raise SdfError(f"<collide_bitmask> is not a whole number: {text!r}") from None
