"""Makes the `Geometry` of a `Robot` from the triangles of its parts.

Every link gets one visual mesh a colour, or a part, and the colliders that `mesh.collider` chooses, in its
own frame. Primitives that the user added to a link stay as they are, unless a target cannot collide their
kind.

- assets: Converts the mesh files of a robot to the format that `mesh.format` and `mesh.assets` select.
- com_check: Checks that a link's centre of mass is within the convex hull of its material.
- contact_parts: Decides which parts with a mesh take part in contact.
- diagnostics: Reports meshes that are missing, were decimated, or enclose another volume than their CAD part.
- geometry: Makes the geometry of a robot: the meshes and colliders of each link, and their file names.
- idle_keys: Reports keys of the mesh stage that are set, but have no effect on this robot.
- library: Reads the part meshes of a bundle: each reply at most once, when the first of its meshes is needed.
- link_mesh: Collects findings about the meshes of a link's parts, and encodes the link's visual meshes.
- link_uses: Collects the parts of each link that have a mesh, and makes the link's visual meshes from them.
- makers: Maps the names of collider makers to their modules.
- motion_digest: Computes a digest of everything on which the poses of a robot's links depend.
- part_choices: Chooses for each part whether it is seen and solid, the maker of its collider, and the
  collider's contact.
- part_mesh: Reads the mesh of each part: its triangles, welded to a surface.
- section: Configuration of the mesh stage: collision and visual geometry.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from linkwright.stages.mesh.configuration.collider_settings import (
    CoacdSettings,
    ColliderSettings,
    ContactSettings,
    GivenSettings,
    HullSettings,
    LadderSettings,
    PrimitiveSettings,
    RawSettings,
    SphereSettings,
)

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import MeshSections
    from linkwright.stages.robot.bundle import Bundle
    from linkwright.stages.robot.model.geometry import Geometry
    from linkwright.stages.robot.model.robot import Robot

VERSION = 61
"""Version of the stage's output: it is raised whenever the same input gives another output."""


class Maker(NamedTuple):
    """How a maker of colliders works."""

    per: Literal["part", "link"]
    """part: a collider for each part, in the part's frame; link: a collider for all parts of a link that the
    same key chooses, in the link's frame."""
    settings: type[ColliderSettings] = ColliderSettings
    """Type of the settings that the maker reads."""
    improves: bool = False
    """Whether the maker has a second, costly step."""
    triangles: int | None = 50_000
    """Number of triangles above which a part is decimated first; None if the maker needs all triangles, or is
    faster than decimation."""


COLLIDERS: Mapping[str, Maker] = {
    "coacd": Maker("part", CoacdSettings, improves=True),
    "hull": Maker("link", HullSettings, triangles=None),
    "ladder": Maker("part", LadderSettings, improves=True),
    "primitives": Maker("part", PrimitiveSettings),
    "raw": Maker("part", RawSettings, triangles=None),
    "spheres": Maker("part", SphereSettings),
    "visual": Maker("link", triangles=None),
}
"""The values of `mesh.collider`: modules of `stages/mesh/colliders`, each with a function `make` and, if it
has a second step, `improve`."""

GIVEN = Maker("link", GivenSettings)
"""The module `stages.mesh.colliders.given`, which fits a primitive that `mesh.colliders` names."""

BY_CONTACT = Maker("link", ContactSettings, triangles=5_000)
"""The package `stages.mesh.by_contact`, which makes the colliders of the ladder without a tolerance."""

PRIMITIVES = ("sphere", "capsule", "box", "cylinder")
"""The kinds of primitives that `mesh.colliders` may name."""

Memo = Callable[[str, Mapping[str, Any], Callable[[], bytes]], bytes]
"""memo(kind, key, make): returns the bytes that were made before for this kind and key, else `make()`.

The caller adds this stage's version and those of its libraries to the key.
"""


Shown = Callable[[Sequence[str], int, int], None]
"""shown(running, done, total): shows progress. `running`: names of the parts whose colliders are being made;
`done`, `total`: numbers of finished colliders and of all."""


def make_geometry(
    robot: Robot, bundle: Bundle, keys: MeshSections, memo: Memo, shown: Shown | None = None
) -> Geometry:
    """Makes the shapes of all links and their files. Reports W-NO-MESH, W-FLAT, W-MESH-VOLUME, W-COM-OUTSIDE,
    W-VISUAL-FACES, I-DECIMATED, I-NO-ASSETS, W-NO-COLLIDER, W-COLLIDER, W-FALSE-CONTACT, I-SMALL-PARTS,
    I-RAW, I-ALWAYS-CONTACT and W-SELF-CONTACT. Raises MeshError if a glob of `geoms`, `mesh.colliders`,
    `ignore` or `contact.exclude` matches nothing, or MuJoCo refuses a collider.

    Each link's visual meshes and each part's collider are made through `memo`, with a key of their content,
    so that renamed links and parts need no new work.
    """
    # Late: the configuration imports this package, but makes no geometry.
    from linkwright.stages.mesh.geometry import build_geometry

    return build_geometry(robot, bundle, keys, memo, shown)
