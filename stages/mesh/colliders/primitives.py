"""The primitive that fits best."""

from collections.abc import Sequence

from linkwright.stages.formats.meshes.surface import Surface, joined
from linkwright.stages.mesh.collide.acceptance import measured
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import PrimitiveSettings
from linkwright.stages.mesh.fit import fittest


def make(surfaces: Sequence[Surface], settings: PrimitiveSettings) -> Collision:
    """However well it fits; none of what lies in a plane."""
    found = fittest(joined(surfaces), settings.target)
    if found is None:
        return Collision(note="it is flat")
    return measured(Collision((found,), rung=found.kind), surfaces, settings.tolerance)
