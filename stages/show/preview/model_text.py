"""Writes the text that MuJoCo compiles: an MJCF or URDF that refers to no other files than meshes."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from posixpath import join, normpath

from linkwright.stages.formats import xml
from linkwright.stages.formats.meshes import glb
from linkwright.stages.formats.meshes.points import binary_stl, is_binary_stl
from linkwright.stages.formats.numbers import spaced
from linkwright.stages.formats.xml import Element, parse, to_bytes
from linkwright.stages.mujoco.includes import replace_includes
from linkwright.stages.mujoco.urdf import prepare_for_inspection
from linkwright.stages.robot.errors import ProtocolError

_PLACEHOLDER = {"type": "sphere", "size": "0.001"}
"""Replacement of a mesh, since only its pose is needed: MuJoCo would take a tenth of a second for each
40,000 triangles."""

_COPYING_ELEMENTS = ("attach", "composite", "flexcomp", "plugin", "replicate")
"""Elements that create bodies from other elements, under other names: such a model keeps its meshes."""


@dataclass(frozen=True, slots=True)
class ScaledStl:
    """The binary STL of a geom, and its scale along x, y and z."""

    path: str
    data: bytes
    scale: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ModelText:
    """The text for MuJoCo, the other `files` by their names in the text, and the meshes that the text leaves
    out, by the name of the geom."""

    text: bytes
    files: Mapping[str, bytes]
    meshes: Mapping[str, ScaledStl]


def mjcf_text(path: str, files: Mapping[str, bytes], *, keep_meshes: bool = False) -> ModelText:
    """Returns the MJCF with its includes in place. Without `keep_meshes`, geoms with a binary STL become
    placeholders."""
    folder = path.rpartition("/")[0]
    root = parse(files[path])
    replace_includes(root, lambda include: parse(files[normpath(join(folder, include.get("file", "")))]))
    # MuJoCo finds files by their paths from the folder of the MJCF.
    files_by_name = {normpath(name[len(folder) :].lstrip("/")): data for name, data in files.items()}
    meshes = {} if keep_meshes else _take_out_meshes(root, files_by_name)
    return ModelText(to_bytes(root), files_by_name, meshes)


def _take_out_meshes(root: Element, files: Mapping[str, bytes]) -> dict[str, ScaledStl]:
    """Replaces the geoms with a binary STL by placeholders, and returns their STLs by the names of the geoms.
    A geom without a name gets one."""
    if (
        any(root.find(f".//{tag}") is not None for tag in _COPYING_ELEMENTS)
        or root.find("default//mesh") is not None
    ):
        return {}
    compilers = (compiler.get("meshdir") for compiler in root.iterfind("compiler"))
    folder = next(filter(None, compilers), "")
    candidates = {name: mesh for mesh in root.iterfind("asset/mesh") if (name := _plain_name(mesh))}
    paths = {name: normpath(join(folder, mesh.get("file", ""))) for name, mesh in candidates.items()}
    types = _DefaultTypes(root)
    needed_meshes: set[str] = set()
    elements_by_mesh: dict[str, list[Element]] = {}
    for element in root.iter():
        # A primitive that is fitted to a mesh needs the mesh, and so does any other element that names it.
        if name := element.get("mesh"):
            is_plain = element.tag == "geom" and types.type_of(element) == "mesh" and name in paths
            if not is_plain or not is_binary_stl(files.get(paths[name], b"")):
                needed_meshes.add(name)
            elements_by_mesh.setdefault(name, []).append(element)
    removed_meshes: dict[str, ScaledStl] = {}
    for name, mesh in candidates.items():
        if name in needed_meshes:
            continue
        scale = tuple(float(number) for number in mesh.get("scale", "1 1 1").split())
        for geom in elements_by_mesh.get(name, ()):
            del geom.attrib["mesh"]
            geom.attrib.update({"name": f"preview:{len(removed_meshes)}", **geom.attrib, **_PLACEHOLDER})
            removed_meshes[geom.get("name")] = ScaledStl(paths[name], files[paths[name]], scale)
        mesh.getparent().remove(mesh)
    return removed_meshes


def _plain_name(mesh: Element) -> str:
    """Returns the name of an MJCF's mesh that only scales its file; "" for other meshes."""
    if set(mesh.attrib) - {"name", "file", "scale", "inertia", "maxhullvert", "class"}:
        return ""
    stem = mesh.get("file", "").rpartition("/")[2].rpartition(".")[0]
    return str(mesh.get("name") or stem)


class _DefaultTypes:
    """Finds the types of geoms, which may come from their default classes."""

    def __init__(self, root: Element) -> None:
        self._types: dict[str, str] = {}
        self._main = "sphere"
        for top in root.iterfind("default"):
            self._main = self._read(top, self._main)

    def _read(self, default: Element, inherited_type: str) -> str:
        geom = default.find("geom")
        type_ = inherited_type if geom is None else str(geom.get("type", inherited_type))
        if default.get("class"):
            self._types[default.get("class")] = type_
        for inner in default.iterfind("default"):
            self._read(inner, type_)
        return type_

    def type_of(self, geom: Element) -> str:
        if geom.get("type"):
            return str(geom.get("type"))
        classes = (ancestor.get("childclass") for ancestor in geom.iterancestors())
        return self._types.get(geom.get("class") or next(filter(None, classes), ""), self._main)


def urdf_text(path: str, files: Mapping[str, bytes]) -> ModelText:
    """Returns the URDF with its visible shapes, each mesh named by its path among the files; it leaves out no
    mesh. Floating joints become fixed, since MuJoCo accepts them only below the world."""
    folder = path.rpartition("/")[0]
    root = parse(files[path])
    files = {**files, **_replace_glbs(root, folder, files)}
    prepare_for_inspection(root, lambda name: _path_among_files(name, folder, files))
    return ModelText(to_bytes(root), files, {})


def _replace_glbs(root: Element, folder: str, files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Replaces each visual GLB, which MuJoCo cannot read, by an STL for each of its colours. Returns the STLs
    by their paths. A malformed GLB stays."""
    stls: dict[str, bytes] = {}
    for mesh in root.xpath("link/visual/geometry/mesh[contains(@filename, '.glb')]"):
        path, visual = _path_among_files(mesh.get("filename"), folder, files), mesh.getparent().getparent()
        try:
            pieces = glb.coloured_triangles(files[path]) if path is not None else []
        except ProtocolError:
            continue
        for number, (corners, colour) in enumerate(pieces):
            stls[f"{path}.{number}.stl"] = binary_stl(corners)
            piece = deepcopy(visual)
            piece.find("geometry/mesh").set("filename", f"{mesh.get('filename')}.{number}.stl")
            if piece.find("material") is None:
                material = xml.element(piece, "material", name=f"{path}.{number}")
                xml.element(material, "color", rgba=spaced(colour))
            visual.addprevious(piece)
        if pieces:
            visual.getparent().remove(visual)
    return stls


def _path_among_files(name: str, folder: str, files: Mapping[str, bytes]) -> str | None:
    """Returns the path among the files that a name in a URDF refers to; None without such a file. The package
    of `package://` is a folder above the URDF's, or the top folder of the files."""
    if not name.startswith("package://"):
        path = normpath(join(folder, name))
        return path if path in files else None
    path_in_package = name.removeprefix("package://").partition("/")[2]
    parent_folder = folder
    while True:
        path = normpath(join(parent_folder, path_in_package))
        if path in files:
            return path
        if not parent_folder:
            return None
        parent_folder = parent_folder.rpartition("/")[0]
