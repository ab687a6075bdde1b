"""The meshes of the parts themselves."""

from collections.abc import Sequence
from dataclasses import replace

from stages.mesh import mesh_file
from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.link_mesh import Collider
from stages.mesh.surface import Surface
from stages.robot.geometry import NEUTRAL


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> tuple[Collider, ...]:
    """Each part's mesh, in several files where it has more triangles than one may have."""
    files = [file for surface in surfaces for file in mesh_file.visuals(surface, NEUTRAL)]
    return tuple(replace(file, colour=None) for file in files)
