"""Reads the visuals, collisions and materials of a URDF."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import cast

from linkwright.stages.formats.urdf.diagnostics import FileDiagnostics
from linkwright.stages.formats.urdf.elements import child, number, numbers, pose
from linkwright.stages.formats.urdf.model import UrdfShape, UrdfShapeKind
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.model.geometry import Colour


@dataclass(frozen=True, slots=True)
class Material:
    """A material of an element."""

    colour: Colour | None
    """RGBA in 0..1; None if it is missing."""

    texture: str
    """The file name of the image, or ""."""


_NO_MATERIAL = Material(None, "")


class Materials:
    """The materials of a robot. A visual's own material is known by its name in the whole file, as in ROS."""

    def __init__(self, robot: Element, log: FileDiagnostics) -> None:
        self._log = log
        self._material_of: dict[Element, Material] = {}
        self._material_by_name: dict[str, Material] = {}
        self._ambiguous_names: set[str] = set()
        for element in robot.iter("{*}material"):
            if tag(element.getparent()) in ("robot", "visual"):
                self._define(element)

    def meant_by(self, element: Element | None) -> Material:
        """Returns the material that a visual's <material> means: its own, or else the material that it
        names."""
        material = _NO_MATERIAL if element is None else self._material_of[element]
        name = "" if element is None else element.get("name", "")
        if material != _NO_MATERIAL or not name:
            return material
        if name not in self._material_by_name:
            self._log.report("W-URDF-MATERIAL", element, f'there is no material "{name}"')
        if name in self._ambiguous_names:
            self._ambiguous_names.discard(name)
            msg = (
                f'material "{name}" is defined several times; here, where it is only named, the first counts'
            )
            self._log.report("W-URDF-MATERIAL", element, msg)
        return self._material_by_name.get(name, material)

    def _define(self, element: Element) -> None:
        log = self._log
        log.count_left_out(element, ("color", "texture"), ("name",))
        colour, texture = child(element, "color", log), child(element, "texture", log)
        material = Material(
            None if colour is None else self._colour(colour),
            "" if texture is None else texture.get("filename", "").strip(),
        )
        self._material_of[element] = material
        name = element.get("name", "")
        if name and material != _NO_MATERIAL:
            first_material = self._material_by_name.setdefault(name, material)
            if first_material != material:
                self._ambiguous_names.add(name)

    def _colour(self, element: Element) -> Colour | None:
        self._log.count_left_out(element, (), ("rgba",))
        text = (element.get("rgba") or "").replace(",", " ").split()
        # Some files leave out alpha.
        channels = numbers(element, "rgba", 3 if len(text) == 3 else 4, self._log)
        if channels is None:
            return None
        rgba = (*channels, 1.0)[:4]
        r, g, b, a = (min(max(value, 0.0), 1.0) + 0.0 for value in rgba)
        if (r, g, b, a) != rgba:
            msg = (
                f'rgba="{" ".join(text)}" is not within 0 and 1, and is taken as ({r:g}, {g:g}, {b:g}, {a:g})'
            )
            self._log.report("W-URDF-COLOUR", element, msg)
        return r, g, b, a


def visuals(link: Element, materials: Materials, log: FileDiagnostics) -> tuple[UrdfShape, ...]:
    """Returns the shapes of a link's visuals."""
    shapes = []
    for element in link:
        if tag(element) == "visual":
            log.count_left_out(element, ("origin", "geometry", "material"), ("name",))
            material = materials.meant_by(child(element, "material", log))
            shapes += [
                replace(shape, colour=material.colour, texture=material.texture)
                for shape in _shape(element, log)
            ]
    return tuple(shapes)


def collisions(link: Element, log: FileDiagnostics) -> tuple[UrdfShape, ...]:
    """Returns the shapes of a link's collisions."""
    shapes = []
    for element in link:
        if tag(element) == "collision":
            # Some exporters give collisions a material, which has no meaning there.
            log.count_left_out(element, ("origin", "geometry", "material"), ("name",))
            shapes += _shape(element, log)
    return tuple(shapes)


def _shape(element: Element, log: FileDiagnostics) -> list[UrdfShape]:
    """Returns the shape of a visual or a collision as a list, empty if it is left out (reports
    W-URDF-SHAPE)."""
    geometry = child(element, "geometry", log)
    place = pose(element, log)
    shapes = (
        [node for node in geometry if tag(node) in _SIZES or tag(node) == "mesh"]
        if geometry is not None
        else []
    )
    if geometry is not None:
        log.count_left_out(geometry, (*_SIZES, "mesh"), ())
    if not shapes:
        log.report("W-URDF-SHAPE", element, f"<{tag(element)}> has no known shape: left out")
        return []
    if len(shapes) > 1:
        log.report("W-URDF-TWICE", shapes[1], "<geometry> has several shapes; the first counts")
    shape = shapes[0]
    kind = cast(UrdfShapeKind, tag(shape))
    size: tuple[float, ...] | None
    if kind == "mesh":
        size = ()
        filename, scale = _mesh(shape, log)
        if not filename:
            return []
    else:
        size, filename, scale = _SIZES[kind](shape, log), "", (1.0, 1.0, 1.0)
    if size is None:
        return []
    if 0.0 in size:
        log.report("W-URDF-SHAPE", shape, f"<{kind}> has no extent: left out")
        return []
    return [UrdfShape(kind, size, filename, scale, place, None, "", element.get("name", ""))]


def _mesh(element: Element, log: FileDiagnostics) -> tuple[str, tuple[float, float, float]]:
    """Returns the file name and the scale of a <mesh>; the name is "" if it is missing (reports E-URDF-MESH)
    or a scale is 0 (reports E-URDF-NUMBER)."""
    log.count_left_out(element, (), ("filename", "scale"))
    filename = element.get("filename", "").strip()
    if not filename:
        log.report("E-URDF-MESH", element, 'a <mesh> needs filename="…"')
    # A single number scales all three axes.
    is_uniform = len((element.get("scale") or "").replace(",", " ").split()) == 1
    factors = numbers(element, "scale", 1 if is_uniform else 3, log) or (1.0,)
    x, y, z = factors if len(factors) == 3 else factors * 3
    if 0.0 in (x, y, z):
        log.report("E-URDF-NUMBER", element, f'<mesh scale="{x:g} {y:g} {z:g}">: no scale may be 0')
        return "", (1.0, 1.0, 1.0)
    return filename, (x, y, z)


def _box_size(element: Element, log: FileDiagnostics) -> tuple[float, ...] | None:
    log.count_left_out(element, (), ("size",))
    return _extents(element, log, numbers(element, "size", 3, log), "size")


def _sphere_size(element: Element, log: FileDiagnostics) -> tuple[float, ...] | None:
    log.count_left_out(element, (), ("radius",))
    return _extents(element, log, numbers(element, "radius", 1, log), "radius")


def _round_size(element: Element, log: FileDiagnostics) -> tuple[float, ...] | None:
    log.count_left_out(element, (), ("radius", "length"))
    radius, length = number(element, "radius", log), number(element, "length", log)
    size = None if radius is None or length is None else (radius, length)
    return _extents(element, log, size, "radius and length")


def _extents(
    element: Element, log: FileDiagnostics, size: tuple[float, ...] | None, attribute: str
) -> tuple[float, ...] | None:
    """Returns a shape's `size` [m]; None if it is missing or negative (reports E-URDF-SHAPE)."""
    if size is None or min(size) < 0:
        log.report("E-URDF-SHAPE", element, f"<{tag(element)}> needs a {attribute} that is not negative")
        return None
    return size


_SIZES: Mapping[str, Callable[[Element, FileDiagnostics], tuple[float, ...] | None]] = {
    "box": _box_size,
    "sphere": _sphere_size,
    "cylinder": _round_size,
    "capsule": _round_size,
}
