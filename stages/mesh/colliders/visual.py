"""Makes no collider: the link is drawn, and touches nothing."""

from collections.abc import Sequence

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import ColliderSettings


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """Returns a collider without pieces."""
    return Collision()
