"""The part meshes of a bundle, each reply read once and only where something must be made of it."""

from collections.abc import Iterable

from stages.mesh import tessellation
from stages.mesh.tessellation import PartMesh
from stages.robot.bundle import Bundle
from stages.robot.model import Link, MeshRef, Part


class MeshLibrary:
    """ProtocolError, on asking, where triangles cannot be read."""

    def __init__(self, links: Iterable[Link], bundle: Bundle) -> None:
        self._bundle = bundle
        self._wanted: dict[str, set[str]] = {}
        self._read: dict[str, dict[str, PartMesh]] = {}
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
