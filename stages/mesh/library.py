"""Reads the part meshes of a bundle: each reply at most once, when the first of its meshes is needed."""

from collections.abc import Iterable

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh import part_mesh
from linkwright.stages.mesh.part_mesh import PartMesh
from linkwright.stages.mesh.visuals.budget import Decimator
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.model.robot import Link, MeshRef, Part

MAX_DECIMATION_MOVE = 1e-4
"""Largest distance [m] by which decimation may move a surface from which colliders are made."""


class MeshLibrary:
    """The meshes of all parts of some links. Its methods raise ProtocolError if triangles cannot be read.
    `decimator`: the decimator that all users of the library share, so that each mesh is decimated once."""

    def __init__(self, links: Iterable[Link], bundle: Bundle) -> None:
        self._bundle = bundle
        self._parts_of_reply: dict[str, set[str]] = {}
        self._meshes_of_reply: dict[str, dict[str, PartMesh]] = {}
        self.decimator = Decimator()
        for link in links:
            for part in link.parts:
                if part.mesh:
                    self._parts_of_reply.setdefault(part.mesh.reply, set()).add(part.mesh.part)

    def meshes_of_parts(self, parts: Iterable[Part]) -> dict[MeshRef, PartMesh]:
        """Returns the meshes of these parts; parts without a mesh are left out."""
        return self.meshes(part.mesh for part in parts if part.mesh)

    def meshes(self, refs: Iterable[MeshRef]) -> dict[MeshRef, PartMesh]:
        """Returns the meshes of these references; references without triangles are left out."""
        result = {}
        for ref in set(refs):
            if ref.reply not in self._meshes_of_reply:
                body = self._bundle.body(ref.reply)
                self._meshes_of_reply[ref.reply] = part_mesh.decode_meshes(
                    body, self._parts_of_reply[ref.reply]
                )
            if ref.part in self._meshes_of_reply[ref.reply]:
                result[ref] = self._meshes_of_reply[ref.reply][ref.part]
        return result

    def surface(self, ref: MeshRef, max_triangles: int | None) -> Surface | None:
        """Returns the surface of a part for making colliders; None if it has no mesh. A surface with more
        than `max_triangles` is decimated, and moves by at most about `MAX_DECIMATION_MOVE`."""
        mesh = self.meshes([ref]).get(ref)
        if mesh and max_triangles is not None and len(mesh.surface.triangles) > max_triangles:
            mesh = self.decimator.decimated(ref, mesh, MAX_DECIMATION_MOVE)
        return mesh.surface if mesh else None
