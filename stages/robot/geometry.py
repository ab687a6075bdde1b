"""The result of the mesh stage: the shapes of every link and their mesh files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from stages.robot.errors import Diagnostic

if TYPE_CHECKING:  # numpy comes with the model
    from stages.robot.model import Primitive

Role = Literal["visual", "collision"]
Colour = tuple[float, float, float, float]

NEUTRAL: Colour = (0.7, 0.7, 0.7, 1.0)
"""The default colour."""


@dataclass(frozen=True, slots=True)
class Shape:
    """One shape of a link: a mesh in the link's frame, or a primitive; the other one is None.

    `file` names an entry of `Geometry.files`; `colour` is RGBA in 0..1 (visual shapes only);
    `area` [m²] and `volume` [m³] are the shape's own (volume 0 where a mesh is not closed). A
    primitive has neither `vertices` nor `faces`, and is a shape once for each role that it has.
    """

    link: str
    role: Role
    file: str | None
    colour: Colour | None
    vertices: int
    faces: int
    area: float
    volume: float
    primitive: Primitive | None = None


@dataclass(frozen=True, slots=True)
class Geometry:
    """Shapes in the order of the links; of a link its colliders, then its visual meshes, then the primitives
    that the user gave it, in their own order. `files`: binary STL by name, metres."""

    shapes: tuple[Shape, ...]
    files: Mapping[str, bytes]
    diagnostics: tuple[Diagnostic, ...] = ()

    def of(self, link: str, role: Role) -> tuple[Shape, ...]:
        return tuple(shape for shape in self.shapes if shape.link == link and shape.role == role)
