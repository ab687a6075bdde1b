"""Configuration of the mesh stage: collision and visual geometry."""

from typing import Annotated, Literal

from pydantic import Field

from linkwright.stages.mesh.configuration.collider_section import (
    CoacdParameters,
    ColliderChoice,
    ColliderName,
    VertexCount,
)
from linkwright.stages.mesh.configuration.geom_section import GeomSection
from linkwright.stages.robot.optional_section import OptionalSection
from linkwright.stages.robot.quantity_keys import NonNegativeLength, PositiveLength
from linkwright.stages.robot.section import Count, NonNegative, Section, Text, example
from linkwright.stages.targets.section import TargetSections


class VisualSection(Section):
    """Visual meshes."""

    merge: Literal["colour", "part"] = "colour"
    """colour: a mesh for each link and colour; part: a mesh for each part, or for each colour of a part with
    several colours."""

    max_faces: Count = 20000
    """Largest number of triangles of a link's visual meshes. A part's surface never moves by more than 0.2 mm
    or 0.3 % of its diagonal, whichever is larger: if that needs more triangles, the link keeps them, with a
    warning."""


class MeshSection(Section):
    """Meshes of the links."""

    collider: ColliderName = "ladder"
    """Collision geometry. ladder: the simplest colliders that touch where the links touch, see below; hull:
    the convex hull of each link; coacd: at most 16 convex pieces for each part; primitives: for each part the
    box, sphere, capsule or cylinder that fits it best, however badly it fits; raw: the mesh of each part as
    it is (MuJoCo and most other engines take its convex hull); spheres: at most 64 spheres for each part,
    fewer where they meet mesh.tolerance; visual: no colliders, the links touch nothing. The ladder in detail:
    each link has a primitive, its convex hull, or the fewest convex pieces with which it touches other links
    only where the links themselves touch. The colliders of links that meet the world also follow their
    surface (mesh.fine). With mesh.tolerance, or for a part that mesh.colliders names, each part has the
    cheapest collider within the tolerance: a primitive, its hull, or at most 16 convex pieces."""

    colliders: Annotated[
        dict[Text, ColliderChoice],
        example({"*finger*": {"make": "coacd", "tolerance": 0.001}, "base": "box", "*screw*": "none"}),
    ] = Field(default_factory=dict)
    """Glob on names of links or parts → how their colliders are made; the last glob that matches counts. If
    it matches the link, a single box or hull encloses all parts of the link; if it matches only a part, the
    box or hull encloses only that part."""

    tolerance: Annotated[PositiveLength | None, example(0.002)] = None
    """Largest distance between a part's surface and its collider's [m], for colliders that can follow the
    surface; 5 % of the collider's surface may stand out up to three times as far. null: the ladder fits
    as closely as contact requires; other colliders have 1.5 % of the diagonal of the part's bounding box, at
    least 0.001."""

    fine: Annotated[Literal["auto", "all"] | tuple[Text, ...], example(["*finger*", "palm"])] = "auto"
    """Links whose colliders by the ladder also follow the surface, to within 1.5 % of the link's diagonal or
    1 mm, whichever is larger, with at most 12 pieces. auto: links that meet the world: the ends of chains,
    the fixed jaws of grippers, and links with a frame whose name says so (foot, tool, grasp ...); all: all
    links; or globs on links."""

    extra_volume: NonNegative = 0.15
    """Largest volume that a single primitive or hull may add to a part, as a share of the volume of the
    part after it is thickened by mesh.tolerance on all sides."""

    max_vertices: VertexCount = 64
    """Largest number of vertices of one hull or convex piece."""

    min_size: Annotated[NonNegativeLength | None, example(0.005)] = None
    """Parts with a smaller diagonal [m] have no collider, unless mesh.colliders names them or the link has
    no other part; null: 1.5 % of the diagonal of the whole link, at least 0.001."""

    effort: Literal["low", "normal", "high"] = "normal"
    """Effort of cutting parts into pieces: how many planes are tried for each cut, and how long CoACD
    searches."""

    basis: Literal["declared", "visual"] = "declared"
    """The basis of colliders if the source is a URDF or MJCF. declared: its own collision shapes
    (primitives stay as they are), or the visual shapes of a link without collision shapes; visual: its visual
    shapes."""

    coacd: CoacdParameters = Field(default_factory=dict)
    """Parameters of CoACD, by its own names, for colliders that it makes. The default `threshold` is twice
    the tolerance, in metres; unless `merge` is true, Linkwright joins pieces as long as they stay within the
    tolerance."""

    visual: VisualSection = VisualSection()
    """Visual meshes."""

    format: Literal["stl", "obj", "glb"] = "stl"
    """Format of the mesh files. stl: binary STL; obj: Wavefront OBJ; glb: the URDF and the SDF show a GLB
    (binary glTF 2) for each link, with its colours, normals and images; colliders, and the visual meshes of
    the MJCF and the USD, are STL. Outside of a GLB, a mesh with a texture is always an OBJ, with an MTL and a
    PNG beside it, since an STL has no texture coordinates."""

    glb_up: Literal["z", "y"] = "z"
    """Axis of a GLB along which the link's z axis points. z: the GLB is in the frame of the link, for readers
    that take it as it is (Gazebo, yourdfpy, three.js, RViz before 15.1.4); y: it is turned, since y points up
    in glTF, for readers that turn it back (RViz from 15.1.4 on, Blender)."""

    assets: Literal["files", "none"] = "files"
    """files: meshes are written beside the model; none: the model has masses and primitives, but no
    meshes."""


class ContactSection(Section):
    """Contact between the links of the robot."""

    exclude: Annotated[tuple[tuple[Text, Text], ...], example([["*_finger", "palm"]])] = ()
    """Pairs of globs on link names: links that do not collide with each other."""

    self_: Annotated[Literal["auto", "none", "all"], Field(alias="self")] = "auto"
    """Contact of the robot with itself. auto: all links collide, except neighbours, and except colliders of
    two links that touch in every pose; none: links do not collide with each other; all: they do, except the
    pairs of `exclude`, and except the two links of a joint, which MuJoCo excludes by itself unless one of
    them is fixed to the world. All links collide with the ground and other objects."""


class IgnoreSection(Section):
    """Links and parts without visual geometry, or without colliders."""

    visual: Annotated[tuple[Text, ...], example(["*cable*"])] = ()
    """Globs on links or parts that are not drawn."""

    collision: Annotated[tuple[Text, ...], example(["*screw*"])] = ()
    """Globs on links or parts that have no collider, whatever mesh.colliders says; no time is spent on making
    it."""


class MeshSections(OptionalSection, TargetSections):
    """The mesh stage's part of the configuration."""

    mesh: MeshSection = MeshSection()
    """Meshes of the links."""

    geoms: Annotated[
        dict[Text, GeomSection], example({"*foot*": {"collision": {"friction": [1.2, 0.005, 0.0001]}}})
    ] = Field(default_factory=dict)
    """Glob on links, or on CAD parts for their colliders → properties of these geoms in the MJCF; later
    entries win, property by property. A part has its own collider if a glob matches it but not its link."""

    contact: ContactSection = ContactSection()
    """Contact between the links of the robot."""

    ignore: IgnoreSection = IgnoreSection()
    """Links and parts without visual geometry, or without colliders, in every format. Their masses stay."""
