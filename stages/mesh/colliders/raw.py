"""Uses the mesh itself as the collider."""

from collections.abc import Sequence
from dataclasses import replace

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.colliders import hull
from linkwright.stages.mesh.configuration.collider_settings import HullSettings, RawSettings


def make(surfaces: Sequence[Surface], settings: RawSettings) -> Collision:
    """Returns the mesh without its texture. If a target limits the vertices of hulls, returns the hull
    instead, which the target would use in any case."""
    if settings.limits.max_hull_vertices is not None:
        return hull.make(surfaces, HullSettings(settings.limits.max_hull_vertices))
    plain = tuple(replace(surface, texcoords=None) for surface in surfaces)
    return Collision(plain, rung="raw", convex=False)
