"""The text that MuJoCo compiles: one MJCF or URDF without links to other files but its meshes."""

from collections.abc import Mapping
from dataclasses import dataclass
from posixpath import join, normpath

from linkwright.stages.formats.meshes.points import is_binary_stl
from linkwright.stages.formats.xml import Element, parse, to_bytes
from linkwright.stages.mujoco.includes import resolve
from linkwright.stages.mujoco.urdf import with_every_link

_PLACEHOLDER = {"type": "sphere", "size": "0.001"}
"""Stands for a mesh: its place counts, and MuJoCo takes a tenth of a second for each 40,000 triangles."""

_COPYING = ("attach", "composite", "flexcomp", "plugin", "replicate")
"""Elements that make bodies of others, with other names."""


@dataclass(frozen=True, slots=True)
class Mesh:
    """The binary STL of a geom, and its scale along x, y and z."""

    path: str
    data: bytes
    scale: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ModelText:
    """What MuJoCo compiles, its other `files` as it names them, and the meshes that are left out of it, by
    the name of the geom."""

    text: bytes
    files: Mapping[str, bytes]
    meshes: Mapping[str, Mesh]


def mjcf_text(path: str, files: Mapping[str, bytes], *, whole: bool = False) -> ModelText:
    """The MJCF with its includes in place; of geoms with a binary STL, but where it is `whole`, only the
    place."""
    folder = path.rpartition("/")[0]
    root = parse(files[path])
    resolve(root, lambda include: parse(files[normpath(join(folder, include.get("file", "")))]))
    own = {normpath(name[len(folder) :].lstrip("/")): data for name, data in files.items()}
    meshes = {} if whole else _without_meshes(root, own)
    return ModelText(to_bytes(root), own, meshes)


def _without_meshes(root: Element, files: Mapping[str, bytes]) -> dict[str, Mesh]:
    """Takes the binary STLs out of a model; by the name of each geom that has one, the mesh."""
    if any(root.find(f".//{tag}") is not None for tag in _COPYING) or root.find("default//mesh") is not None:
        return {}
    folder = next((one.get("meshdir") for one in root.iterfind("compiler") if one.get("meshdir")), "")
    meshes = {name: mesh for mesh in root.iterfind("asset/mesh") if (name := _plain_name(mesh))}
    paths = {name: normpath(join(folder, mesh.get("file", ""))) for name, mesh in meshes.items()}
    types, users = _DefaultTypes(root), dict[str, list[Element]]()
    for one in root.iter():
        # A primitive that is fitted to a mesh needs the mesh, and so does what else names it.
        if name := one.get("mesh"):
            plain = one.tag == "geom" and types.of(one) == "mesh" and name in paths
            if not plain or not is_binary_stl(files.get(paths[name], b"")):
                meshes.pop(name, None)
            users.setdefault(name, []).append(one)
    found: dict[str, Mesh] = {}
    for name, mesh in meshes.items():
        scale = tuple(float(number) for number in mesh.get("scale", "1 1 1").split())
        for geom in users.get(name, ()):
            del geom.attrib["mesh"]
            geom.attrib.update({"name": f"preview:{len(found)}", **geom.attrib, **_PLACEHOLDER})
            found[geom.get("name")] = Mesh(paths[name], files[paths[name]], scale)
        mesh.getparent().remove(mesh)
    return found


def _plain_name(mesh: Element) -> str:
    """The name of a mesh of an MJCF that is its file, scaled; "" for another."""
    if set(mesh.attrib) - {"name", "file", "scale", "inertia", "maxhullvert", "class"}:
        return ""
    stem = mesh.get("file", "").rpartition("/")[2].rpartition(".")[0]
    return str(mesh.get("name") or stem)


class _DefaultTypes:
    """The types that geoms have by their classes."""

    def __init__(self, root: Element) -> None:
        self._types: dict[str, str] = {}
        self._main = "sphere"
        for top in root.iterfind("default"):
            self._main = self._read(top, self._main)

    def _read(self, default: Element, above: str) -> str:
        geom = default.find("geom")
        own = above if geom is None else str(geom.get("type", above))
        if default.get("class"):
            self._types[default.get("class")] = own
        for inner in default.iterfind("default"):
            self._read(inner, own)
        return own

    def of(self, geom: Element) -> str:
        if geom.get("type"):
            return str(geom.get("type"))
        around = (one.get("childclass") for one in geom.iterancestors())
        return self._types.get(geom.get("class") or next(filter(None, around), ""), self._main)


def urdf_text(path: str, files: Mapping[str, bytes]) -> tuple[bytes, Mapping[str, bytes]]:
    """The URDF with each of its meshes by a path among the files, and with all that is seen. Joints that
    float are fixed: MuJoCo accepts them only below the world."""
    folder = path.rpartition("/")[0]
    root = parse(files[path])
    with_every_link(root, lambda name: _place(name, folder, files))
    return to_bytes(root), files


def _place(name: str, folder: str, files: Mapping[str, bytes]) -> str | None:
    """The path among the files of what a URDF names; of `package://` the package is their folder, or one
    above the URDF's."""
    if not name.startswith("package://"):
        found = normpath(join(folder, name))
        return found if found in files else None
    inner = name.removeprefix("package://").partition("/")[2]
    above = folder
    while True:
        found = normpath(join(above, inner))
        if found in files:
            return found
        if not above:
            return None
        above = above.rpartition("/")[0]
