"""The primitive that fits best."""

from collections.abc import Sequence

from linkwright.stages.mesh.collider_settings import ColliderSettings
from linkwright.stages.mesh.collision import Collision
from linkwright.stages.mesh.fit import fittest
from linkwright.stages.mesh.surface import Surface, joined
from linkwright.stages.mesh.verdict import measured


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """However well it fits; none of what lies in a plane."""
    found = fittest(joined(surfaces), settings.target)
    if found is None:
        return Collision(note="it is flat")
    return measured(Collision((found,), rung=found.kind), surfaces, settings)
