"""The part meshes of a bundle, each reply read once and only where something must be made of it."""

from collections.abc import Iterable

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh import tessellation
from linkwright.stages.mesh.tessellation import PartMesh
from linkwright.stages.mesh.visuals.budget import Decimator
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.model.robot import Link, MeshRef, Part

MOVED = 1e-4
"""How far the surface of a part with too many triangles may be moved, to make colliders of it [m]."""


class MeshLibrary:
    """ProtocolError, on asking, where triangles cannot be read. `decimator`: of its meshes, so that none is
    made with fewer triangles twice."""

    def __init__(self, links: Iterable[Link], bundle: Bundle) -> None:
        self._bundle = bundle
        self._wanted: dict[str, set[str]] = {}
        self._read: dict[str, dict[str, PartMesh]] = {}
        self.decimator = Decimator()
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
        would take long, fewer, moved by at most `MOVED`."""
        mesh = self.meshes([ref]).get(ref)
        if mesh and most is not None and len(mesh.surface.triangles) > most:
            mesh = self.decimator.lighter(ref, mesh, MOVED)
        return mesh.surface if mesh else None
