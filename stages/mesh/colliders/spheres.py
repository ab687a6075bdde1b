"""Makes spheres that fill a part."""

from collections.abc import Sequence

from linkwright.stages.formats.meshes.surface import Surface, join_surfaces
from linkwright.stages.mesh import fit
from linkwright.stages.mesh.collide.acceptance import with_measures
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import SphereSettings

MAX_SPHERES = 64
"""Largest number of spheres of a part."""


def make(surfaces: Sequence[Surface], settings: SphereSettings) -> Collision:
    """Makes at most `MAX_SPHERES` spheres that meet the tolerance if possible; no pieces for a flat part."""
    surface = join_surfaces(surfaces)
    spheres = fit.spheres(surface, settings.tolerance_of(surface), MAX_SPHERES)
    if not spheres:
        return Collision(note="it is flat")
    return with_measures(Collision(spheres, rung="spheres"), surfaces, settings.tolerance)
