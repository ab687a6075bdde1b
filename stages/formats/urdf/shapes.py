"""The visuals, collisions and materials of a URDF."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import cast

from stages.formats.urdf.elements import Told, child, number, numbers, pose, tag
from stages.formats.urdf.model import UrdfShape, UrdfShapeKind
from stages.formats.xml import Element
from stages.robot.geometry import Colour


@dataclass(frozen=True, slots=True)
class Material:
    """A material as one element says it: None and "" where it says nothing."""

    colour: Colour | None
    texture: str


_NOTHING = Material(None, "")


class Materials:
    """A robot's materials. One that a visual defines is known by its name in the whole file, as in ROS."""

    def __init__(self, robot: Element, told: Told) -> None:
        self._told = told
        self._said: dict[Element, Material] = {}
        self._named: dict[str, Material] = {}
        self._doubtful: set[str] = set()
        for element in robot.iter("{*}material"):
            if tag(element.getparent()) in ("robot", "visual"):
                self._define(element)

    def of(self, element: Element | None) -> Material:
        """The material that a visual's <material> means: its own, else the one that it names."""
        own = _NOTHING if element is None else self._said[element]
        name = "" if element is None else element.get("name", "")
        if own != _NOTHING or not name:
            return own
        if name not in self._named:
            self._told.tell("W-URDF-MATERIAL", element, f'there is no material "{name}"')
        if name in self._doubtful:
            self._doubtful.discard(name)
            msg = (
                f'material "{name}" is defined several times; here, where it is only named, the first counts'
            )
            self._told.tell("W-URDF-MATERIAL", element, msg)
        return self._named.get(name, own)

    def _define(self, element: Element) -> None:
        told = self._told
        told.check(element, ("color", "texture"), ("name",))
        colour, texture = child(element, "color", told), child(element, "texture", told)
        material = Material(
            None if colour is None else self._colour(colour),
            "" if texture is None else texture.get("filename", "").strip(),
        )
        self._said[element] = material
        name = element.get("name", "")
        if name and material != _NOTHING and self._named.setdefault(name, material) != material:
            self._doubtful.add(name)

    def _colour(self, element: Element) -> Colour | None:
        self._told.check(element, (), ("rgba",))
        text = (element.get("rgba") or "").replace(",", " ").split()
        found = numbers(element, "rgba", 3 if len(text) == 3 else 4, self._told)
        if found is None:
            return None
        given = (*found, 1.0)[:4]
        r, g, b, a = (min(max(value, 0.0), 1.0) + 0.0 for value in given)
        if (r, g, b, a) != given:
            msg = (
                f'rgba="{" ".join(text)}" is not within 0 and 1, and is taken as ({r:g}, {g:g}, {b:g}, {a:g})'
            )
            self._told.tell("W-URDF-COLOUR", element, msg)
        return r, g, b, a


def visuals(link: Element, materials: Materials, told: Told) -> tuple[UrdfShape, ...]:
    found = []
    for element in link:
        if tag(element) == "visual":
            told.check(element, ("origin", "geometry", "material"), ("name",))
            material = materials.of(child(element, "material", told))
            found += [
                replace(one, colour=material.colour, texture=material.texture)
                for one in _shape(element, told)
            ]
    return tuple(found)


def collisions(link: Element, told: Told) -> tuple[UrdfShape, ...]:
    found = []
    for element in link:
        if tag(element) == "collision":
            # Some exporters give collisions a material, which has no meaning there.
            told.check(element, ("origin", "geometry", "material"), ("name",))
            found += _shape(element, told)
    return tuple(found)


def _shape(element: Element, told: Told) -> list[UrdfShape]:
    """The shape of a visual or a collision; none where it is left out, which is told."""
    geometry = child(element, "geometry", told)
    place = pose(element, told)
    known = (
        [one for one in geometry if tag(one) in _SIZES or tag(one) == "mesh"] if geometry is not None else []
    )
    if geometry is not None:
        told.check(geometry, (*_SIZES, "mesh"), ())
    if not known:
        told.tell("W-URDF-SHAPE", element, f"<{tag(element)}> has no shape that is known, and is left out")
        return []
    if len(known) > 1:
        told.tell("W-URDF-TWICE", known[1], "<geometry> has several shapes; the first counts")
    shape = known[0]
    kind = cast(UrdfShapeKind, tag(shape))
    size: tuple[float, ...] | None
    if kind == "mesh":
        size = ()
        filename, scale = _mesh(shape, told)
        if not filename:
            return []
    else:
        size, filename, scale = _SIZES[kind](shape, told), "", (1.0, 1.0, 1.0)
    if size is None:
        return []
    if 0.0 in size:
        told.tell("W-URDF-SHAPE", shape, f"<{kind}> has no extent, and is left out")
        return []
    return [UrdfShape(kind, size, filename, scale, place, None, "", element.get("name", ""))]


def _mesh(element: Element, told: Told) -> tuple[str, tuple[float, float, float]]:
    told.check(element, (), ("filename", "scale"))
    filename = element.get("filename", "").strip()
    if not filename:
        told.tell("E-URDF-MESH", element, 'a <mesh> needs filename="…"')
    several = len((element.get("scale") or "").replace(",", " ").split()) != 1
    found = numbers(element, "scale", 3 if several else 1, told) or (1.0,)
    x, y, z = found if len(found) == 3 else found * 3
    if 0.0 in (x, y, z):
        told.tell("E-URDF-NUMBER", element, f'<mesh scale="{x:g} {y:g} {z:g}">: a mesh cannot be scaled by 0')
        return "", (1.0, 1.0, 1.0)
    return filename, (x, y, z)


def _box(element: Element, told: Told) -> tuple[float, ...] | None:
    told.check(element, (), ("size",))
    return _extents(element, told, numbers(element, "size", 3, told), "size")


def _ball(element: Element, told: Told) -> tuple[float, ...] | None:
    told.check(element, (), ("radius",))
    return _extents(element, told, numbers(element, "radius", 1, told), "radius")


def _round(element: Element, told: Told) -> tuple[float, ...] | None:
    told.check(element, (), ("radius", "length"))
    radius, length = number(element, "radius", told), number(element, "length", told)
    both = None if radius is None or length is None else (radius, length)
    return _extents(element, told, both, "radius and length")


def _extents(
    element: Element, told: Told, found: tuple[float, ...] | None, what: str
) -> tuple[float, ...] | None:
    """A shape's size; None where it lacks or is negative, which is told."""
    if found is None or min(found) < 0:
        told.tell("E-URDF-SHAPE", element, f"<{tag(element)}> needs a {what} that is not negative")
        return None
    return found


_SIZES: Mapping[str, Callable[[Element, Told], tuple[float, ...] | None]] = {
    "box": _box,
    "sphere": _ball,
    "cylinder": _round,
    "capsule": _round,
}
