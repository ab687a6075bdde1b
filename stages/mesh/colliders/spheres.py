"""Spheres that fill the parts."""

from collections.abc import Sequence

from stages.mesh import fit
from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.link_mesh import Collider
from stages.mesh.surface import Surface

MOST = 64
"""The largest number of spheres of a part."""


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> tuple[Collider, ...]:
    """Of each part so many that they meet the tolerance, or the most; none of what lies in a plane."""
    return tuple(
        sphere
        for surface in surfaces
        for sphere in fit.spheres(surface, settings.tolerance_of([surface]), MOST)
    )
