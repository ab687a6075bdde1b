"""The mesh itself."""

from collections.abc import Sequence
from dataclasses import replace

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import ColliderSettings


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """As it is, but for its texture: in several files where it has more triangles than one may have."""
    plain = tuple(replace(surface, texcoords=None) for surface in surfaces)
    return Collision(plain, rung="raw", convex=False)
