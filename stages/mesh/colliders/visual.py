"""No colliders: the links are seen, and touch nothing."""

from collections.abc import Sequence

from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.link_mesh import Collider
from stages.mesh.surface import Surface


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> tuple[Collider, ...]:
    """None."""
    return ()
