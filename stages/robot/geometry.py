"""What the mesh stage hands on: the shapes of every link and the mesh files behind them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from stages.robot.errors import Diagnostic

Role = Literal["visual", "collision"]
Colour = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Shape:
    """One mesh of a link, in the link's frame.

    `file` names an entry of `Geometry.files`; `colour` is RGBA in 0..1 (visual shapes only);
    `area` [m²] and `volume` [m³] are the mesh's own (volume 0 where it is not closed).
    """

    link: str
    role: Role
    file: str
    colour: Colour | None
    vertices: int
    faces: int
    area: float
    volume: float


@dataclass(frozen=True, slots=True)
class Geometry:
    """Shapes sorted by link order, then role, then file; `files`: binary STL by name, metres."""

    shapes: tuple[Shape, ...]
    files: Mapping[str, bytes]
    diagnostics: tuple[Diagnostic, ...] = ()

    def of(self, link: str, role: Role) -> tuple[Shape, ...]:
        return tuple(shape for shape in self.shapes if shape.link == link and shape.role == role)
