"""The mesh itself."""

from collections.abc import Sequence

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import ColliderSettings


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """As it is: in several files where it has more triangles than one may have."""
    return Collision(tuple(surfaces), rung="raw", convex=False)
