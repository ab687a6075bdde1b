"""The result of the mesh stage: the shapes of every link and their mesh files."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geom_form import PLAIN, ContactProperties, GeomForm

if TYPE_CHECKING:  # numpy comes with the model
    from linkwright.stages.robot.model.robot import Primitive

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
    `contact`: what the configuration says of its contacts. `texture`: the entry of `Geometry.files` that is
    the image of a mesh with texture coordinates, times `colour`. `collider`: which of its link's colliders it
    is, or is a piece of, counted as in `Geometry.colliders`; None of what the user gave. `bounds` [m]: of a
    mesh, in the link's frame, the least x, y and z and the largest. `form`: how an MJCF source has it;
    `ellipsoid`: what it is in an MJCF, of a mesh that stands for it elsewhere.
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
    contact: ContactProperties | None = None
    texture: str | None = None
    collider: int | None = None
    bounds: tuple[float, ...] = ()
    form: GeomForm = PLAIN
    ellipsoid: Primitive | None = None


ExcludeReason = Literal["Adjacent", "Always", "Source", "User"]
"""Why two links do not collide: a joint or a rigid connection between them; they touch in whatever pose; the
source says so, an MJCF or an SRDF; the configuration does."""


@dataclass(frozen=True, slots=True)
class Exclude:
    """Two links that do not collide, in the order of the robot's links, or only some of their shapes.

    `depth` [m]: how deep what does not collide is in each other at `home`, 0 where it does not touch.
    `geoms`: the pairs that do not collide, where the others do: positions among the collision shapes of
    `link_a` and of `link_b`, sorted. A format that knows only whole links leaves the links out.
    """

    link_a: str
    link_b: str
    reason: ExcludeReason
    depth: float
    geoms: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, slots=True)
class Touch:
    """Two links that may collide, in the order of the robot's links, and touch at `home`. `depth` [m]: how
    deep they are in each other there, without the shapes that do not collide."""

    link_a: str
    link_b: str
    depth: float


By = Literal["boolean", "sampling"]
"""How volumes were worked out."""


@dataclass(frozen=True, slots=True)
class Measures:
    """How a collider, the union of its pieces, differs from its part.

    `extra`, `missing`: volume of the collider outside the part, and of the part outside the collider, as
    shares of the part's volume, `extra` None where the part has none; `by` what they were worked out.
    Protrusion [m] is the distance from the part of a point of the collider's outer surface, 0 where that is
    within the part; bareness [m] the distance from the collider of a point of the part's surface, 0 where
    that is within a piece. `max` is over all points; `p95` is what 95 % of the area stays within, and no
    area counts for less because it is within.
    """

    extra: float | None
    missing: float
    by: By
    protrusion_p95: float
    protrusion_max: float
    bareness_p95: float
    bareness_max: float


@dataclass(frozen=True, slots=True)
class ColliderFigures:
    """How one or several parts of a link collide.

    `maker`: an option of `mesh.collider`, or "given"; `rung`: what it made, in a word: a kind of primitive,
    "hull", "pieces", "spheres", "raw", or "none". `vertices`: of all its meshes. `tolerance` [m] and
    `measures`: what it was judged by, None where it was not; `meets`: whether it is within the tolerance,
    where its maker goes by one. `miss`: how many times the tolerance it is off, at most 1 where it is within,
    whether its maker goes by that or not. `note`: why it is no better, in words. `failed`: whether that may
    go better next time, since a time limit was hit or a process crashed. `key`: the digest of all that it
    depends on: colliders with the same are made once. `reason`: why a collider by contact is what it is, in
    words.
    """

    link: str
    parts: tuple[str, ...]
    maker: str
    rung: str
    pieces: int
    vertices: int
    meets: bool
    tolerance: float | None
    measures: Measures | None
    miss: float | None = None
    note: str = ""
    failed: bool = False
    key: str = ""
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Geometry:
    """Shapes in the order of the links; of a link its colliders, then its visual meshes, then the primitives
    that the user gave it, in their own order. `files`: binary STL or OBJ by name, metres; of textured meshes
    always OBJ, each with its library of materials (MTL), and the images (PNG). `self_contact`:
    whether the robot's links collide with each other; then `excludes` are the pairs that do not, in the
    order of the links: also those that an engine leaves out by itself; and `touching` those of the others
    that touch at `home`. `colliders`: of each link in its own order, how its parts collide. `by_source`:
    whether what collides is what an MJCF source says, by the bits of its geoms, its pairs and excludes."""

    shapes: tuple[Shape, ...]
    files: Mapping[str, bytes]
    diagnostics: tuple[Diagnostic, ...] = ()
    self_contact: bool = False
    excludes: tuple[Exclude, ...] = ()
    touching: tuple[Touch, ...] = ()
    colliders: tuple[ColliderFigures, ...] = ()
    by_source: bool = False

    @property
    def lasts(self) -> bool:
        """Whether the same inputs give the same again: nothing failed."""
        return not any(one.failed for one in self.colliders)

    def of(self, link: str, role: Role) -> tuple[Shape, ...]:
        """Looks through all shapes: `by_link` is for who asks for every link."""
        return tuple(shape for shape in self.shapes if shape.link == link and shape.role == role)

    def by_link(self) -> defaultdict[tuple[str, Role], list[Shape]]:
        """The same of all links at once, an empty list where there is none."""
        found: defaultdict[tuple[str, Role], list[Shape]] = defaultdict(list)
        for shape in self.shapes:
            found[shape.link, shape.role].append(shape)
        return found
