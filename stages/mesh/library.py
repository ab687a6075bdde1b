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

_SHARES = (0.02, 0.05)
"""How far the surface of a part with too many triangles may be moved, in tolerances; the second where the
first leaves too many."""

MOVED = 5e-5
"""The most that it may be moved [m]."""


class MeshLibrary:
    """ProtocolError, on asking, where triangles cannot be read."""

    def __init__(self, links: Iterable[Link], bundle: Bundle) -> None:
        self._bundle = bundle
        self._wanted: dict[str, set[str]] = {}
        self._read: dict[str, dict[str, PartMesh]] = {}
        self._surfaces: dict[tuple[MeshRef, int | None], Surface] = {}
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

    def surface(self, ref: MeshRef, most: int | None) -> Surface | None:
        """The surface of a part to make colliders of, if there is one: of more than `most` triangles, which
        would take long, fewer, within a small share of the tolerance."""
        if (ref, most) not in self._surfaces:
            mesh = self.meshes([ref]).get(ref)
            if mesh is None:
                return None
            self._surfaces[ref, most] = mesh.surface if most is None else _lighter(mesh, most)
        return self._surfaces[ref, most]


def _lighter(mesh: PartMesh, most: int) -> Surface:
    tolerance = default_tolerance(float(np.linalg.norm(np.ptp(mesh.surface.vertices, axis=0))))
    for share in _SHARES:
        if len(mesh.surface.triangles) <= most:
            break
        from stages.mesh.visuals.simplify import simplified

        plain = replace(mesh, palette=(NEUTRAL,), colours=np.zeros_like(mesh.colours), textures=())
        # A surface moves up to twice as far as it is told.
        mesh = simplified(plain, min(share * tolerance, MOVED / 2)) or mesh
    return mesh.surface
