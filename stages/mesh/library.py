"""The part meshes of a bundle, each reply read once and only where something must be made of it."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from stages.mesh import tessellation
from stages.mesh.collider_settings import default_tolerance
from stages.mesh.surface import Surface
from stages.mesh.tessellation import PartMesh
from stages.robot.bundle import Bundle
from stages.robot.geometry import NEUTRAL
from stages.robot.model import Link, MeshRef, Part

_SHARES = {5_000: 0.02, 50_000: 0.05}
"""How far the surface of a part with more triangles than these may be moved, in tolerances."""

MOVED = 5e-5
"""The most that it may be moved [m]."""


class MeshLibrary:
    """ProtocolError, on asking, where triangles cannot be read."""

    def __init__(self, links: Iterable[Link], bundle: Bundle) -> None:
        self._bundle = bundle
        self._wanted: dict[str, set[str]] = {}
        self._read: dict[str, dict[str, PartMesh]] = {}
        self._light: dict[MeshRef, Surface] = {}
        for link in links:
            for part in link.parts:
                if part.mesh:
                    self._wanted.setdefault(part.mesh.reply, set()).add(part.mesh.part)

    def of_parts(self, parts: Iterable[Part]) -> dict[MeshRef, PartMesh]:
        """The meshes of these parts, where there are any."""
        return self.meshes(part.mesh for part in parts if part.mesh)

    def meshes(self, refs: Iterable[MeshRef]) -> dict[MeshRef, PartMesh]:
        """The meshes that these refer to, where there are any."""
        result = {}
        for ref in set(refs):
            if ref.reply not in self._read:
                body = self._bundle.body(ref.reply)
                self._read[ref.reply] = tessellation.read(body, self._wanted[ref.reply])
            if ref.part in self._read[ref.reply]:
                result[ref] = self._read[ref.reply][ref.part]
        return result

    def light(self, ref: MeshRef) -> Surface | None:
        """The surface of a part to make colliders of, if there is one: of many triangles, which would take
        seconds, fewer, within a small share of the tolerance."""
        if ref not in self._light:
            mesh = self.meshes([ref]).get(ref)
            if mesh is None:
                return None
            self._light[ref] = _lighter(mesh)
        return self._light[ref]


def _lighter(mesh: PartMesh) -> Surface:
    tolerance = default_tolerance(float(np.linalg.norm(np.ptp(mesh.surface.vertices, axis=0))))
    for many, share in _SHARES.items():
        if len(mesh.surface.triangles) <= many:
            break
        from stages.mesh.visuals.simplify import simplified

        plain = replace(mesh, palette=(NEUTRAL,), colours=np.zeros_like(mesh.colours), textures=())
        mesh = simplified(plain, min(share * tolerance, MOVED)) or mesh
    return mesh.surface
