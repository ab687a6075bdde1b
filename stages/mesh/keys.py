"""Configuration of the mesh stage: collision and visual geometry."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, Field

from stages.mesh import COLLIDERS
from stages.mesh.decompose_options import search
from stages.mesh.geom_keys import GeomKeys
from stages.robot.errors import ConfigError
from stages.robot.keys import Count, Keys, Later, NonNegative, Positive, Text, example, invalid, not_yet

LATER_COLLIDERS = ("ladder",)
"""Colliders that are decided but not supported yet."""


if TYPE_CHECKING:
    ColliderName = str
else:
    ColliderName = Literal[tuple(COLLIDERS)]


def _of_coacd(given: dict[str, Any]) -> dict[str, Any]:
    try:
        search("normal", given)
    except ConfigError as error:
        hint = f"; {error.hint}" if error.hint else ""
        raise invalid(f"{error.where.rpartition('.')[2]}: {error.message}{hint}") from None
    return given


class VisualKeys(Keys):
    """Visual meshes."""

    merge: Literal["colour", "part"] = "colour"
    """colour: one mesh per link and colour; part: one mesh per part, and one for each of its colours where it
    has several."""

    max_faces: Count = 20000
    """Largest number of triangles of a link. A part's surface never moves by more than 0.2 mm or 0.3 % of
    its diagonal, whichever is more: where that takes more triangles, the link keeps them, with a warning."""


class MeshSection(Keys):
    """Meshes of the links."""

    collider: Annotated[ColliderName, Later(*LATER_COLLIDERS)] = "hull"
    """Collision geometry. hull: the convex hull of each link; coacd: at most 16 convex pieces of each
    part; primitives: of each part the box, sphere, capsule or cylinder that fits it best, however well;
    raw: the mesh of each part as it is, of which MuJoCo and most other engines take the convex hull;
    spheres: at most 64 spheres for each part, fewer where they meet mesh.tolerance; visual: none, the
    links touch nothing."""

    tolerance: Annotated[Positive | None, example(0.002)] = None
    """Largest distance between a part's surface and its collider's [m], for the colliders that can follow it;
    null: 1.5 % of the diagonal of the part's bounding box, at least 0.001."""

    extra_volume: NonNegative = not_yet(0.15)
    """Largest share of volume that a collider may add."""

    max_vertices: Annotated[Count, Field(ge=4)] = not_yet(64)
    """Largest number of vertices of one convex piece."""

    effort: Literal["normal"] = not_yet("normal")
    """How long a decomposition may search."""

    colliders: dict[Text, Text] = not_yet(dict)
    """Glob on link names → its own collider."""

    target: Literal["mujoco", "mjx"] = "mujoco"
    """The engine that the colliders are made for. mjx: without cylinders, which MJX collides with no mesh."""

    coacd: Annotated[dict[Text, Any], AfterValidator(_of_coacd), example({"mcts_iterations": 100})] = Field(
        default_factory=dict
    )
    """Parameters of CoACD, by its own names, wherever a part is decomposed. Without a `threshold` it is twice
    the tolerance, in metres; pieces are merged by the volume that it adds, unless `merge` is true."""

    visual: VisualKeys = VisualKeys()
    """Visual meshes."""

    format: Literal["stl", "obj"] = "stl"
    """Format of the mesh files. stl: binary STL; obj: Wavefront OBJ. A mesh with a texture is always an OBJ,
    with an MTL and the PNG beside it: an STL has no texture coordinates."""

    assets: Literal["files", "none"] = "files"
    """files: meshes are written beside the model; none: the model has masses and
    primitives, but no meshes."""


class ContactKeys(Keys):
    """Contact between the links of the robot."""

    exclude: Annotated[tuple[tuple[Text, Text], ...], example([["*_finger", "palm"]])] = ()
    """Pairs of globs on link names: links that do not collide with each other."""

    self_: Annotated[Literal["auto", "none", "all"], Field(alias="self")] = "none"
    """Contact of the robot with itself. auto: links collide with each other, except those next to each other
    and those that touch in every pose; none: they do not; all: they do, except the pairs of `exclude`, and
    except the links on either side of a joint, which MuJoCo leaves out by itself unless one of them is
    fixed to the world. All collide with the ground and other objects."""


class MeshKeys(Keys):
    """The mesh stage's part of the configuration."""

    mesh: MeshSection = MeshSection()
    """Meshes of the links."""

    geoms: Annotated[
        dict[Text, GeomKeys], example({"*foot*": {"collision": {"friction": [1.2, 0.005, 0.0001]}}})
    ] = Field(default_factory=dict)
    """Glob on link names → properties of their geoms in the MJCF; later entries win, property by property."""

    contact: ContactKeys = ContactKeys()
    """Contact between the links of the robot."""
