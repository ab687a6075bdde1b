"""Spheres that fill a part."""

from collections.abc import Sequence

from linkwright.stages.formats.meshes.surface import Surface, joined
from linkwright.stages.mesh import fit
from linkwright.stages.mesh.collide.acceptance import measured
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import SphereSettings

MOST = 64
"""The largest number of spheres of a part."""


def make(surfaces: Sequence[Surface], settings: SphereSettings) -> Collision:
    """So many that they meet the tolerance, or the most; none of what lies in a plane."""
    whole = joined(surfaces)
    found = fit.spheres(whole, settings.tolerance_of(whole), MOST)
    if not found:
        return Collision(note="it is flat")
    return measured(Collision(found, rung="spheres"), surfaces, settings.tolerance)
