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


class VisualSection(Section):
    """Visual meshes."""

    merge: Literal["colour", "part"] = "colour"
    """colour: one mesh per link and colour; part: one mesh per part, and one for each of its colours where it
    has several."""

    max_faces: Count = 20000
    """Largest number of triangles of a link. A part's surface never moves by more than 0.2 mm or 0.3 % of
    its diagonal, whichever is more: where that takes more triangles, the link keeps them, with a warning."""


class MeshSection(Section):
    """Meshes of the links."""

    collider: ColliderName = "ladder"
    """Collision geometry. ladder: of each link a primitive, its convex hull, or as few convex pieces as
    it takes for its colliders to touch other links only where the links do, and for links that meet the
    world to follow them (mesh.fine); with mesh.tolerance, or for a part that mesh.colliders names, of
    each part the cheapest of a primitive, its hull, and at most 16 convex pieces that is within the
    tolerance; hull: the convex hull of each link; coacd: at most 16 convex pieces of each part;
    primitives: of each part the box, sphere, capsule or cylinder that fits it best, however well; raw:
    the mesh of each part as it is, of which MuJoCo and most other engines take the convex hull; spheres:
    at most 64 spheres for each part, fewer where they meet mesh.tolerance; visual: none, the links touch
    nothing."""

    colliders: Annotated[
        dict[Text, ColliderChoice],
        example({"*finger*": {"make": "coacd", "tolerance": 0.001}, "base": "box", "*screw*": "none"}),
    ] = Field(default_factory=dict)
    """Glob on names of links or parts → how their colliders are made; the last glob that matches counts. Of
    a link that is named, one box or hull is for all of its parts; of a part, for this part alone."""

    tolerance: Annotated[PositiveLength | None, example(0.002)] = None
    """Largest distance between a part's surface and its collider's [m], for the colliders that can follow it;
    a twentieth of the collider's surface may stand out up to three times as far. null: contact decides how
    near the colliders of the ladder are; for others, 1.5 % of the diagonal of the part's bounding box, at
    least 0.001."""

    fine: Annotated[Literal["auto", "all"] | tuple[Text, ...], example(["*finger*", "palm"])] = "auto"
    """Links whose colliders by contact follow them to 1.5 % of their diagonal, at least 0.001, with at most
    12 pieces. auto: what meets the world, which is the ends of chains, the jaws beside which these move, and
    links with a frame that is named for it (foot, tool, grasp ...); all; or globs on links."""

    extra_volume: NonNegative = 0.15
    """Largest volume that one primitive or hull for a whole part may add, as a share of the part's own with a
    layer of mesh.tolerance around it."""

    max_vertices: VertexCount = 64
    """Largest number of vertices of one hull or convex piece."""

    min_size: Annotated[NonNegativeLength | None, example(0.005)] = None
    """Parts with a smaller diagonal [m] have no collider, unless mesh.colliders names them or the link has
    no other part; null: the tolerance of the whole link, 1.5 % of its diagonal and at least 0.001."""

    effort: Literal["low", "normal", "high"] = "normal"
    """How thoroughly parts are cut into pieces: how many planes are tried for each cut, and how long CoACD
    searches."""

    target: Literal["mujoco", "mjx"] = "mujoco"
    """The engine that the colliders are made for. mjx: without cylinders and ellipsoids, which MJX collides
    with no mesh; cylinders of the source, and those that are named, become prisms of the same volume, and
    ellipsoids their hulls."""

    basis: Literal["declared", "visual"] = "declared"
    """What colliders are made of where the source is a URDF or MJCF. declared: its own collision shapes, of
    which primitives stay as they are; where a link has none, its visual ones; visual: its visual shapes."""

    coacd: CoacdParameters = Field(default_factory=dict)
    """Parameters of CoACD, by its own names, for colliders that it makes. Without a `threshold` it is twice
    the tolerance, in metres; pieces are joined as long as they are near enough, unless `merge` is true."""

    visual: VisualSection = VisualSection()
    """Visual meshes."""

    format: Literal["stl", "obj"] = "stl"
    """Format of the mesh files. stl: binary STL; obj: Wavefront OBJ. A mesh with a texture is always an OBJ,
    with an MTL and the PNG beside it: an STL has no texture coordinates."""

    assets: Literal["files", "none"] = "files"
    """files: meshes are written beside the model; none: the model has masses and
    primitives, but no meshes."""


class ContactSection(Section):
    """Contact between the links of the robot."""

    exclude: Annotated[tuple[tuple[Text, Text], ...], example([["*_finger", "palm"]])] = ()
    """Pairs of globs on link names: links that do not collide with each other."""

    self_: Annotated[Literal["auto", "none", "all"], Field(alias="self")] = "auto"
    """Contact of the robot with itself. auto: links collide with each other, except those next to each other
    and those that touch in every pose, or only those of their colliders that do so; none: they do not; all:
    they do, except the pairs of `exclude`, and except the links on either side of a joint, which MuJoCo
    leaves out by itself unless one of them is fixed to the world. All collide with the ground and other
    objects."""


class IgnoreSection(Section):
    """Links and parts without visual geometry, or without colliders."""

    visual: Annotated[tuple[Text, ...], example(["*cable*"])] = ()
    """Globs on links or parts that are not drawn."""

    collision: Annotated[tuple[Text, ...], example(["*screw*"])] = ()
    """Globs on links or parts that have no collider, whatever mesh.colliders says, and cost none."""


class MeshSections(OptionalSection):
    """The mesh stage's part of the configuration."""

    mesh: MeshSection = MeshSection()
    """Meshes of the links."""

    geoms: Annotated[
        dict[Text, GeomSection], example({"*foot*": {"collision": {"friction": [1.2, 0.005, 0.0001]}}})
    ] = Field(default_factory=dict)
    """Glob on links, or on CAD parts for their colliders → properties of these geoms in the MJCF; later
    entries win, property by property. A part that a glob names, and not its link, has its own collider."""

    contact: ContactSection = ContactSection()
    """Contact between the links of the robot."""

    ignore: IgnoreSection = IgnoreSection()
    """Links and parts without visual geometry, or without colliders, in every format. Their masses stay."""
