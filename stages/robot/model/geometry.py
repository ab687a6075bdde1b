"""Describes the result of the mesh stage: the shapes of every link and their mesh files."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geom_form import PLAIN, ContactProperties, GeomForm

if TYPE_CHECKING:  # the model imports numpy
    from linkwright.stages.robot.model.robot import Primitive

Role = Literal["visual", "collision"]

Colour = tuple[float, float, float, float]
"""RGBA in 0..1."""

NEUTRAL: Colour = (0.7, 0.7, 0.7, 1.0)
"""The default colour."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A shape of a link: a mesh in the link's frame, or a primitive. A primitive with both roles is two
    shapes."""

    link: str
    role: Role
    file: str | None
    """The mesh: an entry of `Geometry.files`; None for a primitive."""
    colour: Colour | None
    """The colour; None for collision shapes."""
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
    """The contact properties that the configuration sets for the shape."""
    texture: str | None = None
    """The image of a mesh with texture coordinates, an entry of `Geometry.files`; `colour` multiplies it."""
    collider: int | None = None
    """The index, among the link's colliders in `Geometry.colliders`, of the collider that has this shape;
    None for the user's own shapes."""
    bounds: tuple[float, ...] = ()
    """The least x, y and z of a mesh, and the largest, in the link's frame [m]; () for a primitive."""
    form: GeomForm = PLAIN
    """The properties of the geom in an MJCF source."""
    ellipsoid: Primitive | None = None
    """The ellipsoid that an MJCF has in place of this mesh; None for other shapes."""


ExcludeReason = Literal["Adjacent", "Always", "Source", "User"]
"""The reason why two links do not collide. Adjacent: a joint or a rigid connection between them; Always: they
touch in every pose; Source: an MJCF or an SRDF says so; User: the configuration says so."""


@dataclass(frozen=True, slots=True)
class Exclude:
    """Two links, in the order of the robot's links, of which all or some shapes do not collide."""

    link_a: str
    link_b: str
    reason: ExcludeReason
    depth: float
    """Penetration at `home` [m] of the shapes that do not collide; 0 if they do not touch."""
    geoms: tuple[tuple[int, int], ...] = ()
    """The pairs of shapes that do not collide, sorted, as indices among the collision shapes of `link_a` and
    of `link_b`; () if no pair collides. Formats that exclude only whole links leave out excludes with
    pairs."""


@dataclass(frozen=True, slots=True)
class Touch:
    """Two links that may collide and that touch at `home`, in the order of the robot's links."""

    link_a: str
    link_b: str
    depth: float
    """Penetration at `home` [m] of the shapes that may collide."""


VolumeMethod = Literal["boolean", "sampling"]
"""The method by which volumes were computed."""


@dataclass(frozen=True, slots=True)
class Measures:
    """The differences between a collider, which is the union of its pieces, and its part.

    Protrusion is the distance [m] of a point of the collider's outer surface from the part, 0 inside the
    part. Bareness is the distance [m] of a point of the part's surface from the collider, 0 inside a piece.
    `max` is over all points; for 95 % of the area, inner area included, the distance is at most `p95`.
    """

    extra: float | None
    """Volume of the collider outside the part, as a share of the part's volume; None if the part has none."""
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
    """The option of `mesh.collider` that made the collider, or "given"."""
    rung: str
    """The kind of the collider: a kind of primitive, "hull", "pieces", "spheres", "raw", or "none"."""
    pieces: int
    vertices: int
    """Number of vertices of all its meshes."""
    meets: bool
    """Whether the collider is within the tolerance, if its maker has one."""
    tolerance: float | None
    """The tolerance [m] by which the collider was judged; None if it was not judged."""
    measures: Measures | None
    """The measures by which the collider was judged; None if it was not judged."""
    miss: float | None = None
    """The error in units of the tolerance, at most 1 within the tolerance, also if the maker has none."""
    note: str = ""
    """Why the collider is not better, in words."""
    failed: bool = False
    """Whether another run may give a better collider, since a time limit was hit or a process crashed."""
    key: str = ""
    """Digest of all that the collider depends on: colliders with the same key are made once."""
    reason: str = ""
    """Why a collider by contact has its shape, in words."""


@dataclass(frozen=True, slots=True)
class Geometry:
    """The shapes of a robot, and the files of their meshes."""

    shapes: tuple[Shape, ...]
    """In the order of the links; for each link its colliders, then its visual meshes, then the user's
    primitives."""
    files: Mapping[str, bytes]
    """File name → content, in metres: meshes as binary STL or OBJ, whole visuals as GLB; a textured mesh is
    an OBJ with a library of materials (MTL) and images (PNG)."""
    diagnostics: tuple[Diagnostic, ...] = ()
    self_contact: bool = False
    """Whether the robot's links collide with each other."""
    excludes: tuple[Exclude, ...] = ()
    """With `self_contact`, the pairs that do not collide, in the order of the links. Pairs that an engine
    never lets collide are included."""
    touching: tuple[Touch, ...] = ()
    """With `self_contact`, the other pairs that touch at `home`."""
    colliders: tuple[ColliderFigures, ...] = ()
    """The colliders of the parts, link by link."""
    by_source: bool = False
    """Whether contacts follow an MJCF source: the bits of its geoms, its pairs and its excludes."""
    whole_visuals: tuple[Shape, ...] = ()
    """For each link with visual meshes, a shape with all of them in a single file (GLB), for formats that
    accept it; () without `mesh.format: glb`."""

    @property
    def with_whole_visuals(self) -> Geometry:
        """The geometry as URDF and SDF have it: the whole visual of a link replaces its visual meshes."""
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
        """Returns the geometry of formats that use the visual meshes (`meshes`), the whole visuals (`whole`),
        or both, with only the files that its shapes use."""
        if not self.whole_visuals:
            return self
        geometry = self if meshes else self.with_whole_visuals
        geometry = geometry if meshes and whole else replace(geometry, whole_visuals=())
        shapes = (*geometry.shapes, *geometry.whole_visuals)
        file_names = {name for shape in shapes for name in (shape.file, shape.texture) if name is not None}
        # An OBJ refers to its library of materials.
        file_names |= {f"{name.removesuffix('.obj')}.mtl" for name in file_names if name.endswith(".obj")}
        return replace(
            geometry, files={name: data for name, data in self.files.items() if name in file_names}
        )

    @property
    def lasts(self) -> bool:
        """Whether the same inputs would give the same result again, since no collider failed."""
        return not any(collider.failed for collider in self.colliders)

    def shapes_of(self, link: str, role: Role) -> tuple[Shape, ...]:
        """Returns the shapes of a link in a role. It scans all shapes; for all links, `by_link` is faster."""
        return tuple(shape for shape in self.shapes if shape.link == link and shape.role == role)

    def by_link(self) -> defaultdict[tuple[str, Role], list[Shape]]:
        """Returns the shapes by link and role; an empty list for a link without shapes in a role."""
        shapes: defaultdict[tuple[str, Role], list[Shape]] = defaultdict(list)
        for shape in self.shapes:
            shapes[shape.link, shape.role].append(shape)
        return shapes
