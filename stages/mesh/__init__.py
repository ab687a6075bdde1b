"""Mesh: a `Robot` and the triangles of its parts in, a `Geometry` out.

Every link gets one visual mesh a colour, or a part, and the colliders that `mesh.collider` chooses, in its
own frame. The primitives that the user gave it stay as they are.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stages.mesh.keys import MeshKeys
    from stages.robot.bundle import Bundle
    from stages.robot.geometry import Geometry
    from stages.robot.model import Robot

VERSION = 14
"""Grows with every change of what this stage makes of the same input."""

COLLIDERS: Mapping[str, tuple[str, ...]] = {
    "coacd": ("tolerance", "max_vertices", "coacd"),
    "hull": (),
    "primitives": ("target",),
    "raw": (),
    "spheres": ("tolerance",),
    "visual": (),
}
"""The values of `mesh.collider`: modules of `stages/mesh/colliders`, each with a function `make` (a
`ColliderMaker`); and the names of the `ColliderSettings` that each reads."""

Memo = Callable[[str, Mapping[str, Any], Callable[[], bytes]], bytes]
"""memo(kind, key, make): the bytes that were made before for this kind and key, else `make()`.

The caller adds this stage's version and those of its libraries to the key.
"""


def make_geometry(robot: Robot, bundle: Bundle, keys: MeshKeys, memo: Memo) -> Geometry:
    """The shapes of all links and their files. Diagnostics: W-NO-MESH, W-FLAT,
    W-MESH-VOLUME, W-COM-OUTSIDE, W-VISUAL-FACES, I-DECIMATED, I-NO-ASSETS,
    W-NO-COLLIDER, I-RAW, I-ALWAYS-CONTACT, W-SELF-CONTACT.
    MeshError where `geoms` or `contact.exclude` match no links, or MuJoCo refuses a collider.

    Each link is made through `memo`, by the content of its parts: renaming one makes nothing again.
    """
    from stages.mesh.geometry import geometry

    return geometry(robot, bundle, keys, memo)
