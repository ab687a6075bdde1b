"""The robot's geometry: each link's meshes made once, then named."""

from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from stages.mesh import COLLIDERS, link_mesh, primitives, tessellation, textures
from stages.mesh.assets import written
from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.com_check import unbalanced
from stages.mesh.contacts.analysis import self_contacts
from stages.mesh.diagnostics import diagnostics
from stages.mesh.geoms import contact_properties, with_properties
from stages.mesh.link_mesh import ColliderMaker, Finding, LinkMesh, Use
from stages.mesh.mesh_file import MeshFile
from stages.mesh.names import file_names, part_words
from stages.mesh.tessellation import PartMesh
from stages.mesh.visuals.budget import Decimator
from stages.robot.bundle import Bundle
from stages.robot.geometry import Geometry, Role, Shape
from stages.robot.model import Link, MeshRef, Part, Robot

if TYPE_CHECKING:
    from stages.mesh import Memo
    from stages.mesh.keys import MeshKeys, MeshSection


def geometry(robot: Robot, bundle: Bundle, keys: "MeshKeys", memo: "Memo") -> Geometry:
    """The shapes of all links. ProtocolError where triangles cannot be read, MeshError where a glob of
    `geoms` matches no link."""
    properties = contact_properties([link.name for link in robot.links], keys.geoms)
    library, decimator = _Library(robot.links, bundle), Decimator()
    meshes: dict[str, LinkMesh] = {}
    found, owners = {}, {}
    for link in robot.links:
        # Sorted by content: neither a new name nor another order of instances makes the work again.
        uses = [
            (Use(part.mesh, part.link_from_part, part.collides, part.seen), part)
            for part in link.parts
            if part.mesh
        ]
        uses.sort(key=lambda pair: pair[0].key())
        meshes[link.name] = mesh = _link_mesh([use for use, _ in uses], library, decimator, keys.mesh, memo)
        owners[link.name] = [uses[index][1] for index in mesh.owners]
        lacking = [(part, Finding(False, None)) for part in link.parts if part.mesh is None]
        found[link.name] = [*zip((part for _, part in uses), mesh.findings, strict=True), *lacking]
    named, files = _named(meshes, owners)
    files |= textures.images(meshes.values(), bundle)
    shapes = [shape for link in robot.links for shape in (*named[link.name], *primitives.shapes(link))]
    problems = diagnostics(robot.links, meshes, found, keys.mesh.collider) + unbalanced(
        robot.links, meshes, library.of_parts
    )
    contacts = self_contacts(robot, shapes, files, keys.contact, memo)
    problems += contacts.diagnostics
    (shown, assets), left_out = written(with_properties(shapes, properties), files, keys.mesh)
    return Geometry(shown, assets, (*problems, *left_out), contacts.on, contacts.excludes)


def _link_mesh(
    uses: list[Use], library: "_Library", decimator: Decimator, section: "MeshSection", memo: "Memo"
) -> LinkMesh:
    if not uses:
        return LinkMesh((), (), ())
    collider, settings = section.collider, ColliderSettings.of(section)

    def make() -> bytes:
        maker: ColliderMaker = import_module(f"stages.mesh.colliders.{collider}").make
        meshes = library.meshes(use.mesh for use in uses)
        return link_mesh.encode(link_mesh.make(uses, meshes, maker, settings, section.visual, decimator))

    used = settings.used(COLLIDERS[collider])
    key = {
        "collider": collider,
        "settings": used,
        "visual": section.visual.identity(),
        "parts": [use.key() for use in uses],
    }
    return link_mesh.decode(memo("mesh.link", key, make))


class _Library:
    """The part meshes of a bundle, each reply read once and only where a link must be made."""

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


def _named(
    meshes: Mapping[str, LinkMesh], owners: Mapping[str, Sequence[Part]]
) -> tuple[dict[str, list[Shape]], dict[str, bytes]]:
    """The shapes of each link's meshes and colliders, and their files by name. `owners`: the part of each
    visual mesh, by link, where each has one of its own."""
    names = file_names(
        {
            link: (
                part_words([part.name for part in owners[link]]) or len(mesh.visuals),
                sum(isinstance(one, MeshFile) for one in mesh.colliders),
            )
            for link, mesh in meshes.items()
        }
    )
    shapes: dict[str, list[Shape]] = {}
    files: dict[str, bytes] = {}
    for link, mesh in meshes.items():
        visual_names, collider_names = names[link]
        shapes[link] = []
        free = iter(collider_names)
        for collider in mesh.colliders:
            if isinstance(collider, MeshFile):
                name = next(free)
                shapes[link].append(_shape(link, "collision", name, collider))
                files[name] = collider.data
            else:
                shapes[link].append(primitives.collider(link, collider))
        for name, file in zip(visual_names, mesh.visuals, strict=True):
            shapes[link].append(_shape(link, "visual", name, file))
            files[name] = file.data
    return shapes, dict(sorted(files.items()))


def _shape(link: str, role: Role, name: str, file: MeshFile) -> Shape:
    texture = textures.name(file.texture) if file.texture else None
    return Shape(
        link, role, name, file.colour, file.vertices, file.faces, file.area, file.volume, texture=texture
    )
