"""A primitive for each part."""

from collections.abc import Sequence

from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.fit import fittest
from stages.mesh.link_mesh import Collider
from stages.mesh.surface import Surface


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> tuple[Collider, ...]:
    """The one that fits each part best, however well; none of a part that lies in a plane."""
    found = (fittest(surface, settings.target) for surface in surfaces)
    return tuple(primitive for primitive in found if primitive is not None)
