"""Mesh: a `Robot` and the triangles of its parts in, a `Geometry` out.

Every link gets one visual mesh a colour, or a part, and the colliders that `mesh.collider` chooses, in its
own frame. The primitives that the user gave it stay as they are, but for cylinders where MJX is the target.

- assets: The mesh files of a robot in the form that `mesh.format` and `mesh.assets` ask for.
- com_check: Whether a link's centre of mass lies within its material.
- contact_parts: Which parts take part in contact, of those that have a mesh.
- diagnostics: Diagnostics of the mesh stage about missing, open and decimated meshes.
- geometry: The robot's geometry: each link's meshes and colliders, made once, then named.
- idle_keys: Keys of the mesh stage that nothing of this robot depends on.
- library: The part meshes of a bundle, each reply read once and only where something must be made of it.
- link_mesh: What is known of the meshes of a link's parts, and its visual meshes made of them, both as bytes
  too.
- link_uses: The parts of each link that have a mesh, and the visual meshes that are made of them.
- makers: The table of the makers of colliders.
- motion_digest: What decides where the links of a robot are, as a digest.
- part_choices: What is asked of each part: whether it is seen and solid, who makes its collider, and the
  contact of that.
- section: Configuration of the mesh stage: collision and visual geometry.
- tessellation: Each part's triangles, welded to a surface, in the part studio's frame.
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
    SphereSettings,
)

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import MeshSections
    from linkwright.stages.robot.bundle import Bundle
    from linkwright.stages.robot.model.geometry import Geometry
    from linkwright.stages.robot.model.robot import Robot

VERSION = 53
"""Grows with every change of what this stage makes of the same input."""


class Maker(NamedTuple):
    """What a maker of colliders works on, and the settings that it reads.

    `per`: part, one collider for each part, in its own frame; link, one for all parts of a link that the
    same key chooses, in the link's frame. `improves`: whether it has a second, costly step; `triangles`:
    of a part with more some are left out first; None where all are needed, or take less time than that.
    """

    per: Literal["part", "link"]
    settings: type[ColliderSettings] = ColliderSettings
    improves: bool = False
    triangles: int | None = 50_000


COLLIDERS: Mapping[str, Maker] = {
    "coacd": Maker("part", CoacdSettings, improves=True),
    "hull": Maker("link", HullSettings, triangles=None),
    "ladder": Maker("part", LadderSettings, improves=True),
    "primitives": Maker("part", PrimitiveSettings),
    "raw": Maker("part", triangles=None),
    "spheres": Maker("part", SphereSettings),
    "visual": Maker("link", triangles=None),
}
"""The values of `mesh.collider`: modules of `stages/mesh/colliders`, each with a function `make` and, where
it improves, `improve`."""

GIVEN = Maker("link", GivenSettings)
"""The module `stages.mesh.colliders.given`: a primitive that `mesh.colliders` names."""

BY_CONTACT = Maker("link", ContactSettings, triangles=5_000)
"""The package `stages.mesh.by_contact`: what the ladder is without a tolerance."""

PRIMITIVES = ("sphere", "capsule", "box", "cylinder")
"""The primitives that may be named there."""

Memo = Callable[[str, Mapping[str, Any], Callable[[], bytes]], bytes]
"""memo(kind, key, make): the bytes that were made before for this kind and key, else `make()`.

The caller adds this stage's version and those of its libraries to the key.
"""


Shown = Callable[[Sequence[str], int, int], None]
"""shown(running, done, total): the names of the parts whose colliders are being made, and how many of all
are done."""


def make_geometry(
    robot: Robot, bundle: Bundle, keys: MeshSections, memo: Memo, shown: Shown | None = None
) -> Geometry:
    """The shapes of all links and their files. Diagnostics: W-NO-MESH, W-FLAT,
    W-MESH-VOLUME, W-COM-OUTSIDE, W-VISUAL-FACES, I-DECIMATED, I-NO-ASSETS,
    W-NO-COLLIDER, W-COLLIDER, W-FALSE-CONTACT, I-SMALL-PARTS, I-RAW, I-ALWAYS-CONTACT, W-SELF-CONTACT.
    MeshError where `geoms`, `mesh.colliders`, `ignore` or `contact.exclude` match nothing, or MuJoCo refuses
    a collider.

    Each link's visual meshes and each part's collider are made through `memo`, by content: renaming one
    makes nothing again.
    """
    # Late: the configuration reads this package and makes nothing.
    from linkwright.stages.mesh.geometry import geometry

    return geometry(robot, bundle, keys, memo, shown)
