"""Describes the result of the mesh stage: the shapes of every link and their mesh files."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
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
    """A shape of a link: a mesh in the link's frame, or a primitive. A primitive is a shape once for each
    role that it has."""

    link: str
    role: Role
    file: str | None
    """The mesh: an entry of `Geometry.files`; None for a primitive."""
    colour: Colour | None
    """RGBA in 0..1; None for collision shapes."""
    vertices: int
    """Number of vertices of the mesh; 0 for a primitive."""
    faces: int
    """Number of triangles of the mesh; 0 for a primitive."""
    area: float
    """Surface area [m²]."""
    volume: float
    """Volume [m³]; 0 for a mesh that is not closed."""
    primitive: Primitive | None = None
    """The primitive; None for a mesh."""
    contact: ContactProperties | None = None
    """The configuration's contact properties of the shape."""
    texture: str | None = None
    """The image of a mesh with texture coordinates, an entry of `Geometry.files`; `colour` multiplies it."""
    collider: int | None = None
    """The number of the link's collider in `Geometry.colliders` that the shape is, or is a piece of; None for
    the user's own shapes."""
    bounds: tuple[float, ...] = ()
    """The least x, y and z and the largest of a mesh, in the link's frame [m]."""
    form: GeomForm = PLAIN
    """The properties of the geom in an MJCF source."""
    ellipsoid: Primitive | None = None
    """The ellipsoid that an MJCF has in place of this mesh."""


ExcludeReason = Literal["Adjacent", "Always", "Source", "User"]
"""The reason why two links do not collide. Adjacent: a joint or a rigid connection between them; Always: they
touch in every pose; Source: an MJCF or an SRDF says so; User: the configuration says so."""


@dataclass(frozen=True, slots=True)
class Exclude:
    """Two links that do not collide, in the order of the robot's links, or only some of their shapes."""

    link_a: str
    link_b: str
    reason: ExcludeReason
    depth: float
    """Penetration at `home` [m] of the shapes that do not collide; 0 if they do not touch."""
    geoms: tuple[tuple[int, int], ...] = ()
    """Pairs of shapes that do not collide, if others do: positions among the collision shapes of `link_a` and
    of `link_b`, sorted. A format that knows only whole links leaves this exclude out."""


@dataclass(frozen=True, slots=True)
class Touch:
    """Two links that may collide and that touch at `home`, in the order of the robot's links."""

    link_a: str
    link_b: str
    depth: float
    """Penetration at `home` [m], without the shapes that do not collide."""


VolumeMethod = Literal["boolean", "sampling"]
"""The method by which volumes were computed."""


@dataclass(frozen=True, slots=True)
class Measures:
    """The differences of a collider, the union of its pieces, from its part.

    Protrusion is the distance [m] from the part of a point of the collider's outer surface, 0 within the
    part. Bareness is the distance [m] from the collider of a point of the part's surface, 0 within a piece.
    `max` is over all points; `p95` bounds 95 % of the area, where area within counts fully.
    """

    extra: float | None
    """Volume of the collider outside the part, as a share of the part's volume; None if that is 0."""
    missing: float
    """Volume of the part outside the collider, as a share of the part's volume."""
    by: VolumeMethod
    """The method by which the volumes were computed."""
    protrusion_p95: float
    protrusion_max: float
    bareness_p95: float
    bareness_max: float


@dataclass(frozen=True, slots=True)
class ColliderFigures:
    """The collider of a part, or of several parts, of a link."""

    link: str
    parts: tuple[str, ...]
    maker: str
    """The option of `mesh.collider` that made it, or "given"."""
    rung: str
    """Its kind: a kind of primitive, "hull", "pieces", "spheres", "raw", or "none"."""
    pieces: int
    vertices: int
    """Number of vertices of all its meshes."""
    meets: bool
    """Whether it is within the tolerance, where its maker has one."""
    tolerance: float | None
    """The tolerance [m] by which it was judged; None if it was not judged."""
    measures: Measures | None
    """The measures by which it was judged; None if it was not judged."""
    miss: float | None = None
    """Its error in units of the tolerance: at most 1 within the tolerance, whether its maker uses one or
    not."""
    note: str = ""
    """Why it is no better, in words."""
    failed: bool = False
    """Whether another run may do better, since a time limit was hit or a process crashed."""
    key: str = ""
    """Digest of all that it depends on: colliders with the same key are made once."""
    reason: str = ""
    """Why a collider by contact is as it is, in words."""


@dataclass(frozen=True, slots=True)
class Geometry:
    """The shapes of a robot, and the files of their meshes."""

    shapes: tuple[Shape, ...]
    """In the order of the links; for each link its colliders, then its visual meshes, then the user's
    primitives."""
    files: Mapping[str, bytes]
    """File name → content, in metres: binary STL or OBJ; textured meshes are OBJ files, with a library of
    materials (MTL) and images (PNG)."""
    diagnostics: tuple[Diagnostic, ...] = ()
    self_contact: bool = False
    """Whether the robot's links collide with each other."""
    excludes: tuple[Exclude, ...] = ()
    """With `self_contact`, the pairs that do not collide, in the order of the links; also those that an
    engine leaves out by itself."""
    touching: tuple[Touch, ...] = ()
    """With `self_contact`, the other pairs that touch at `home`."""
    colliders: tuple[ColliderFigures, ...] = ()
    """The colliders of the parts, link by link."""
    by_source: bool = False
    """Whether contacts follow an MJCF source: the bits of its geoms, its pairs and its excludes."""
    whole_visuals: tuple[Shape, ...] = ()
    """For each link with visual meshes, a shape that has all of them in one file (GLB), for formats whose
    readers take it; () without `mesh.format: glb`."""

    @property
    def with_whole_visuals(self) -> Geometry:
        """The geometry as URDF and SDF have it: in the place of a link's visual meshes all of them as one."""
        whole_visuals = {shape.link: shape for shape in self.whole_visuals}
        if not whole_visuals:
            return self
        shapes: list[Shape] = []
        for shape in self.shapes:
            if shape.role == "collision" or shape.file is None:
                shapes.append(shape)
            elif shape.link in whole_visuals:
                shapes.append(whole_visuals.pop(shape.link))
        return replace(self, shapes=tuple(shapes))

    def shown(self, *, meshes: bool, whole: bool) -> Geometry:
        """Returns the geometry of formats that show the visual meshes themselves, or all of a link as one, or
        both, with the files that they name."""
        if not self.whole_visuals:
            return self
        geometry = self if meshes else self.with_whole_visuals
        geometry = geometry if meshes and whole else replace(geometry, whole_visuals=())
        shapes = (*geometry.shapes, *geometry.whole_visuals)
        file_names = {name for shape in shapes for name in (shape.file, shape.texture) if name is not None}
        # The materials of a textured OBJ are beside it.
        file_names |= {f"{name.removesuffix('.obj')}.mtl" for name in file_names if name.endswith(".obj")}
        return replace(
            geometry, files={name: data for name, data in self.files.items() if name in file_names}
        )

    @property
    def lasts(self) -> bool:
        """Whether the same inputs would give the same result: nothing failed."""
        return not any(collider.failed for collider in self.colliders)

    def shapes_of(self, link: str, role: Role) -> tuple[Shape, ...]:
        """Returns the shapes of a link in a role. It scans all shapes; `by_link` is faster for every link."""
        return tuple(shape for shape in self.shapes if shape.link == link and shape.role == role)

    def by_link(self) -> defaultdict[tuple[str, Role], list[Shape]]:
        """Returns the shapes of all links by link and role; an empty list where there are none."""
        shapes: defaultdict[tuple[str, Role], list[Shape]] = defaultdict(list)
        for shape in self.shapes:
            shapes[shape.link, shape.role].append(shape)
        return shapes
