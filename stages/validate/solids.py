"""The shapes that a robot's links have, as a file has to have them, for formats whose files are read as they
are written."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePosixPath
from typing import Protocol

import numpy as np

from stages.robot.check import Finding
from stages.robot.fusing import Holders
from stages.robot.geometry import Colour, Geometry, Role, Shape
from stages.robot.model import Array
from stages.robot.plural import count
from stages.robot.poses import UNMOVED
from stages.validate.coordinates import SAME
from stages.validate.findings import differs, place_differs, shown

COLOUR = 1e-4
"""Of each channel; a screen has steps of 1/255."""

ROLES: tuple[Role, Role] = ("visual", "collision")


@dataclass(frozen=True, slots=True, eq=False)
class WrittenShape:
    """What a file has to have. `kind`: that of a primitive, or "mesh"; `size` [m] as in `model.Primitive`, ()
    for a mesh; `file`: the name of a mesh's file, "" for none; `link_from_shape` (4, 4). `colour`: RGBA, None
    where nothing is known of it; `texture`: the name of its image, "" for none."""

    kind: str
    size: tuple[float, ...]
    file: str
    link_from_shape: Array
    colour: Colour | None = None
    texture: str = ""


class ReadShape(Protocol):
    """What a file has: `filename` is that of a mesh, as the file has it, and `scale` that of a mesh;
    `texture` is that of an image."""

    @property
    def kind(self) -> str: ...
    @property
    def size(self) -> tuple[float, ...]: ...
    @property
    def filename(self) -> str: ...
    @property
    def scale(self) -> tuple[float, ...]: ...
    @property
    def link_from_shape(self) -> Array: ...
    @property
    def colour(self) -> Colour | None: ...
    @property
    def texture(self) -> str: ...


@dataclass(frozen=True, slots=True)
class ShapeWords:
    """What a format calls the file and the scale of a mesh, position and turn of a shape, and its colour."""

    file: str
    scale: str
    place: tuple[str, str]
    colour: str


def solid_of(shape: Shape) -> WrittenShape:
    """A shape as it is."""
    one, look = shape.primitive, (shape.colour, shape.texture or "")
    if one is None:
        return WrittenShape("mesh", (), str(shape.file), UNMOVED, *look)
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
    for number, (shape, one) in enumerate(zip(shapes, wanted, strict=True)):
        which = f"{role} {number + 1}"
        yield from _looks(element, f"{which} {words.colour}", shape, one)
        if shape.kind != one.kind:
            yield differs(element, f"{which} geometry", shape.kind or "none", one.kind)
        elif one.file and PurePosixPath(shape.filename).name != PurePosixPath(one.file).name:
            yield differs(element, f"{which} {words.file}", shape.filename, one.file)
        elif one.file and shape.scale != (1.0, 1.0, 1.0):
            yield differs(element, f"{which} {words.scale}", shape.scale, (1.0, 1.0, 1.0))
        elif not np.allclose(shape.size, one.size, rtol=SAME, atol=SAME):
            message = f"is {shown(shape.size)}, expected {shown(one.size)} [m]"
            yield Finding(element, f"{which} {one.kind} size", message)
        else:
            attributes = (f"{which} {words.place[0]}", f"{which} {words.place[1]}")
            yield from place_differs(element, shape.link_from_shape, one.link_from_shape, attributes, SAME)


def _looks(element: str, attribute: str, shape: ReadShape, wanted: WrittenShape) -> Iterator[Finding]:
    if wanted.colour is None:
        return
    image = PurePosixPath(shape.texture).name
    if image != wanted.texture:
        yield differs(element, attribute, image or "no image", wanted.texture or "no image")
    elif not same_colour(shape.colour, wanted.colour):
        yield differs(element, attribute, shape.colour, wanted.colour)


def same_colour(found: Sequence[float] | Array | None, wanted: Colour) -> bool:
    """Whether both are the same within what a screen shows."""
    return found is not None and bool(np.allclose(found, wanted, rtol=0, atol=COLOUR))
