"""The text that MuJoCo compiles: one MJCF or URDF without links to other files but its meshes."""

from collections.abc import Mapping
from posixpath import join, normpath

from stages.formats.xml import Element, element, parse, to_bytes


def mjcf_text(path: str, files: Mapping[str, bytes]) -> tuple[str, Mapping[str, bytes]]:
    """The MJCF with its includes in place, and its other files as it names them."""
    folder = path.rpartition("/")[0]
    root = parse(files[path])
    for include in list(root.iter("include")):
        other = parse(files[normpath(join(folder, include.get("file", "")))])
        at = include.getparent().index(include)
        include.getparent()[at : at + 1] = list(other)
    own = {normpath(name[len(folder) :].lstrip("/")): data for name, data in files.items()}
    return to_bytes(root).decode(), own


def urdf_text(path: str, files: Mapping[str, bytes]) -> tuple[str, Mapping[str, bytes]]:
    """The URDF with each of its meshes by a path among the files, and with all that is seen. Joints that
    float are fixed: MuJoCo accepts them only below the world."""
    folder = path.rpartition("/")[0]
    root = parse(files[path])
    for mesh in list(root.iter("mesh")):
        place = _place(mesh.get("filename", ""), folder, files)
        if place is None:
            _drop(mesh)
        else:
            mesh.set("filename", place)
    for settings in root.findall("mujoco"):
        root.remove(settings)
    own = element(root, "mujoco")
    element(own, "compiler", strippath="false", fusestatic="false", discardvisual="false")
    for joint in root.iterfind("joint[@type='floating']"):
        joint.set("type", "fixed")
    return to_bytes(root).decode(), files


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


def _drop(mesh: Element) -> None:
    around = mesh.getparent().getparent()
    if around is not None and around.getparent() is not None:
        around.getparent().remove(around)
