"""Each link has the shapes of the robot: as many, of their files and sizes, where they must be, and of their
colours."""

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
from linkwright.stages.validate.findings import differs, place_differs, shown
from linkwright.stages.validate.model.coordinates import SAME

COLOUR = 1e-4
"""Of each channel; a screen has steps of 1/255."""

WITHIN = 2e-5
"""Bounds of meshes [m], and relatively beyond a metre: points are in single precision."""

ROLES: tuple[Role, Role] = ("visual", "collision")


@dataclass(frozen=True, slots=True, eq=False)
class WrittenShape:
    """What a file has to have. `kind`: that of a primitive, or "mesh"; `size` [m] as in `model.Primitive`, ()
    for a mesh; `file`: the name of a mesh's file, "" for none; `link_from_shape` (4, 4). `colour`: RGBA, None
    where nothing is known of it; `texture`: the name of its image, "" for none. `bounds` and `area`: of a
    mesh, as in `geometry.Shape`."""

    kind: str
    size: tuple[float, ...]
    file: str
    link_from_shape: Array
    colour: Colour | None = None
    texture: str = ""
    bounds: tuple[float, ...] = ()
    area: float = 0.0


class ReadShape(Protocol):
    """What a file has: `filename` is that of a mesh, as the file has it, None where it does not say it, and
    `scale` that of a mesh; `texture` is that of an image."""

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
    """What a format calls the kind of a shape, the file and the scale of a mesh, position and turn of a
    shape, and its colour."""

    kind: str
    file: str
    scale: str
    place: tuple[str, str]
    colour: str


def solid_of(shape: Shape) -> WrittenShape:
    """A shape as it is."""
    one, look = shape.primitive, (shape.colour, shape.texture or "")
    if one is None:
        return WrittenShape("mesh", (), str(shape.file), UNMOVED, *look, shape.bounds, shape.area)
    return WrittenShape(one.kind, tuple(one.size), "", one.link_from_shape, *look)


def solids_by_link(
    geometry: Geometry, solids: Callable[[Shape], Iterable[WrittenShape]], held: Holders
) -> Mapping[tuple[str, Role], list[WrittenShape]]:
    """By link of a file and role: what it has, in the order of the links that it holds. `solids`: what stands
    in the file for a shape; `held`: the holders of links that are part of others, and where they are."""
    by_link = geometry.by_link()
    found: dict[tuple[str, Role], list[WrittenShape]] = {}
    for name in dict.fromkeys((*held, *(shape.link for shape in geometry.shapes))):
        holder, place = held.get(name, (name, UNMOVED))
        for role in ROLES:
            own = found.setdefault((holder, role), [])
            for shape in by_link[name, role]:
                every = solids(shape)
                own += [replace(one, link_from_shape=place @ one.link_from_shape) for one in every]
    return found


def differences(
    element: str, role: str, shapes: Sequence[ReadShape], wanted: Sequence[WrittenShape], words: ShapeWords
) -> Iterator[Finding]:
    """What a link's shapes of one role are otherwise than they have to be. `element`: the link."""
    if len(shapes) != len(wanted):
        yield Finding(element, role, f"has {count(len(shapes), role)}, expected {len(wanted)}")
        return
    for number, (shape, one) in enumerate(zip(shapes, wanted, strict=True), 1):
        yield from look_differs(element, f"{role} {number} {words.colour}", shape, one)
        yield from form_differs(element, f"{role} {number} ", shape, one, words, SAME)


def form_differs(
    element: str, which: str, shape: ReadShape, wanted: WrittenShape, words: ShapeWords, least: float
) -> Iterator[Finding]:
    """What one shape is otherwise: its kind, file or size, else its place, by more than `least`. `which`: how
    attributes begin."""
    if shape.kind != wanted.kind:
        yield differs(element, f"{which}{words.kind}", shape.kind or "none", wanted.kind)
    elif wanted.file and shape.filename is not None and _name(shape.filename) != _name(wanted.file):
        yield differs(element, f"{which}{words.file}", shape.filename, wanted.file)
    elif wanted.file and shape.scale != (1.0, 1.0, 1.0):
        yield differs(element, f"{which}{words.scale}", shape.scale, (1.0, 1.0, 1.0))
    elif not np.allclose(shape.size, wanted.size, rtol=least, atol=least):
        message = f"is {shown(shape.size)}, expected {shown(wanted.size)} [m]"
        yield Finding(element, f"{which}{wanted.kind} size", message)
    else:
        attributes = (f"{which}{words.place[0]}", f"{which}{words.place[1]}")
        yield from place_differs(element, shape.link_from_shape, wanted.link_from_shape, attributes, least)


def look_differs(element: str, attribute: str, shape: ReadShape, wanted: WrittenShape) -> Iterator[Finding]:
    """What colour or image a shape has otherwise."""
    if wanted.colour is None:
        return
    image = _name(shape.texture)
    if image != wanted.texture:
        yield differs(element, attribute, image or "no image", wanted.texture or "no image")
    elif not same_colour(shape.colour, wanted.colour):
        yield differs(element, attribute, shape.colour, wanted.colour)


def bounds_differ(
    element: str, attribute: str, found: Sequence[float], wanted: WrittenShape
) -> Iterator[Finding]:
    """Whether the points of a mesh are where those of its file are."""
    off = float(np.abs(np.subtract(found, wanted.bounds)).max())
    if not off <= WITHIN * max(1.0, float(np.abs(wanted.bounds).max())):
        message = f"its bounds are {shown(1e3 * off)} mm off those of {wanted.file}"
        yield Finding(element, attribute, message)


def _name(path: str) -> str:
    return PurePosixPath(path).name


def same_colour(found: Sequence[float] | Array | None, wanted: Colour) -> bool:
    """Whether both are the same within what a screen shows."""
    return found is not None and bool(np.allclose(found, wanted, rtol=0, atol=COLOUR))
