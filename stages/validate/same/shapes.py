"""Compares the shapes of each link with the robot's: their number, files, sizes, places and colours."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePosixPath
from typing import Protocol

import numpy as np

from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.dynamics.fusing import Holders
from linkwright.stages.robot.model.geometry import Colour, Geometry, Role, Shape
from linkwright.stages.robot.model.poses import UNMOVED
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import differs, pose_findings, shown
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE

COLOUR_TOLERANCE = 1e-4
"""Tolerance of each colour channel; a screen has steps of 1/255."""

BOUNDS_TOLERANCE = 2e-5
"""Tolerance of the bounds of meshes [m], relative above a metre: points are in single precision."""

ROLES: tuple[Role, Role] = ("visual", "collision")


@dataclass(frozen=True, slots=True, eq=False)
class WrittenShape:
    """A shape that a file must have."""

    kind: str
    """The kind of a primitive, or "mesh"."""

    size: tuple[float, ...]
    """The size [m] as in `model.Primitive`; () for a mesh."""

    file: str
    """The name of a mesh's file; "" for a primitive."""

    link_from_shape: Array
    """The pose (4, 4) in the link."""

    colour: Colour | None = None
    """RGBA; None if it is not known."""

    texture: str = ""
    """The name of the image; "" without an image."""

    bounds: tuple[float, ...] = ()
    """The bounds of a mesh, as in `geometry.Shape`."""

    area: float = 0.0
    """The area of a mesh, as in `geometry.Shape`."""


class ReadShape(Protocol):
    """A shape of a file. A mesh has a `filename`, None if the file does not give it, and a `scale`. `texture`
    is the name of an image's file."""

    @property
    def kind(self) -> str: ...
    @property
    def size(self) -> tuple[float, ...]: ...
    @property
    def filename(self) -> str | None: ...
    @property
    def scale(self) -> tuple[float, ...]: ...
    @property
    def link_from_shape(self) -> Array: ...
    @property
    def colour(self) -> Sequence[float] | None: ...
    @property
    def texture(self) -> str: ...


@dataclass(frozen=True, slots=True)
class ShapeWords:
    """A format's names for the properties of a shape."""

    kind: str
    file: str
    """The file of a mesh."""

    scale: str
    """The scale of a mesh."""

    place: tuple[str, str]
    """The position and the orientation."""

    colour: str


def solid_of(shape: Shape) -> WrittenShape:
    """Returns a shape as it is written by default, in its own form."""
    primitive, look = shape.primitive, (shape.colour, shape.texture or "")
    if primitive is None:
        return WrittenShape("mesh", (), str(shape.file), UNMOVED, *look, shape.bounds, shape.area)
    return WrittenShape(primitive.kind, tuple(primitive.size), "", primitive.link_from_shape, *look)


def solids_by_link(
    geometry: Geometry, solids: Callable[[Shape], Iterable[WrittenShape]], held: Holders
) -> Mapping[tuple[str, Role], list[WrittenShape]]:
    """Maps each link of a file and role to its shapes, in the order of the links that it holds. `solids`:
    returns the shapes of the file for a shape; `held`: the holders of links that are part of other links, and
    their places."""
    by_link = geometry.by_link()
    by_role: dict[tuple[str, Role], list[WrittenShape]] = {}
    for name in dict.fromkeys((*held, *(shape.link for shape in geometry.shapes))):
        holder, holder_from_link = held.get(name, (name, UNMOVED))
        for role in ROLES:
            shapes_of_holder = by_role.setdefault((holder, role), [])
            for shape in by_link[name, role]:
                solids_of_link_shape = solids(shape)
                shapes_of_holder += [
                    replace(solid, link_from_shape=holder_from_link @ solid.link_from_shape)
                    for solid in solids_of_link_shape
                ]
    return by_role


def differences(
    element: str,
    role: str,
    shapes: Sequence[ReadShape],
    expected: Sequence[WrittenShape],
    format_names: ShapeWords,
) -> Iterator[Finding]:
    """Yields the differences of a link's shapes of a role. `element`: the title of the link."""
    if len(shapes) != len(expected):
        yield Finding(element, role, f"has {count(len(shapes), role)}, expected {len(expected)}")
        return
    for number, (shape, expected_shape) in enumerate(zip(shapes, expected, strict=True), 1):
        yield from look_differs(element, f"{role} {number} {format_names.colour}", shape, expected_shape)
        yield from form_differs(
            element, f"{role} {number} ", shape, expected_shape, format_names, ENGINE_TOLERANCE
        )


def form_differs(
    element: str,
    prefix: str,
    shape: ReadShape,
    expected: WrittenShape,
    format_names: ShapeWords,
    tolerance: float,
) -> Iterator[Finding]:
    """Yields the differences of a shape: of its kind, file or size, else of its place. `tolerance` [m, rad]:
    the largest difference that is ignored; `prefix`: what the names of the attributes begin with."""
    if shape.kind != expected.kind:
        yield differs(element, f"{prefix}{format_names.kind}", shape.kind or "none", expected.kind)
    elif expected.file and shape.filename is not None and _name(shape.filename) != _name(expected.file):
        yield differs(element, f"{prefix}{format_names.file}", shape.filename, expected.file)
    elif expected.file and shape.scale != (1.0, 1.0, 1.0):
        yield differs(element, f"{prefix}{format_names.scale}", shape.scale, (1.0, 1.0, 1.0))
    elif not np.allclose(shape.size, expected.size, rtol=tolerance, atol=tolerance):
        message = f"is {shown(shape.size)}, expected {shown(expected.size)} [m]"
        yield Finding(element, f"{prefix}{expected.kind} size", message)
    else:
        attributes = (f"{prefix}{format_names.place[0]}", f"{prefix}{format_names.place[1]}")
        yield from pose_findings(
            element, shape.link_from_shape, expected.link_from_shape, attributes, tolerance
        )


def look_differs(element: str, attribute: str, shape: ReadShape, expected: WrittenShape) -> Iterator[Finding]:
    """Yields the difference of a shape's colour or image."""
    if expected.colour is None:
        return
    image = _name(shape.texture)
    if image != expected.texture:
        yield differs(element, attribute, image or "no image", expected.texture or "no image")
    elif not same_colour(shape.colour, expected.colour):
        yield differs(element, attribute, shape.colour, expected.colour)


def bounds_differ(
    element: str, attribute: str, actual: Sequence[float], expected: WrittenShape
) -> Iterator[Finding]:
    """Compares the bounds of a mesh with those of its file."""
    difference = float(np.abs(np.subtract(actual, expected.bounds)).max())
    if not difference <= BOUNDS_TOLERANCE * max(1.0, float(np.abs(expected.bounds).max())):
        message = f"its bounds are {shown(1e3 * difference)} mm off those of {expected.file}"
        yield Finding(element, attribute, message)


def _name(path: str) -> str:
    return PurePosixPath(path).name


def same_colour(actual: Sequence[float] | Array | None, expected: Colour) -> bool:
    """Tells whether two colours are the same on a screen."""
    return actual is not None and bool(np.allclose(actual, expected, rtol=0, atol=COLOUR_TOLERANCE))
