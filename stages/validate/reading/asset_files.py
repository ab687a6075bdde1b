"""Finds the files that a model names: meshes, textures and height fields."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.system.regular_files import is_file
from linkwright.stages.validate.reading.documents import ModelDocument

_MESH_FOLDER_TAGS = ("mesh", "hfield", "skin", "flexcomp")
"""Elements of an MJCF whose files are in the compiler's `meshdir`."""

_SIDE_ATTRIBUTES = tuple(f"file{side}" for side in ("back", "down", "front", "left", "right", "up"))
"""Attributes of a texture for the six sides of a cube."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedFile:
    """A file that an element of a model names."""

    element: Element
    attribute: str
    text: str
    """The value of the attribute."""

    path: Path | None
    """Where the file is; None if the folder of its package is not known."""


def referenced_files(document: ModelDocument) -> Iterator[NamedFile]:
    """Yields every file that the model, or a file that it includes, names."""
    if document.language == "urdf":
        yield from _files_of_urdf(document)
    else:
        yield from _files_of_mjcf(document)


def package_of(text: str) -> str:
    """Returns the package that a path starts with; "" for a plain path."""
    return text.partition("://")[2].partition("/")[0] if is_of_package(text) else ""


def is_of_package(text: str) -> bool:
    """Tells whether a path is relative to a package's folder. The package's name may be missing, as in
    `package:///a.stl`."""
    return text.startswith(("package://", "model://"))


def _files_of_urdf(document: ModelDocument) -> Iterator[NamedFile]:
    folder = document.path.parent
    compilers = document.root.iterfind("mujoco/compiler")
    (meshdir,) = [compiler.get("meshdir", "") for compiler in compilers][:1] or [""]
    for element in document.root.iter("mesh", "texture"):
        text = element.get("filename", "")
        if not text.strip() or any("ros2_control" in tag(ancestor) for ancestor in element.iterancestors()):
            continue
        yield NamedFile(element, "filename", text, _resolved(text, folder, meshdir, document.packages))


def _resolved(text: str, folder: Path, meshdir: str, packages: tuple[str, ...] | None) -> Path | None:
    """Returns the file that a path of a URDF leads to, from the URDF's `folder` or from that of a package.

    Returns None if no folder of the package has the file. A path without a package leads to a file even if
    the file does not exist. `packages`: the names of the packages whose root is `folder`, None for any.
    """
    if is_of_package(text):
        name = package_of(text)
        path_in_package = unquote(text.partition("://")[2].partition("/")[2])
        candidates = [folder / path_in_package] if packages is None or name in packages else []
        for ancestor_folder in (folder.resolve(), *folder.resolve().parents):
            # A package is a folder of its name: beside the URDF, or around it.
            candidates += [
                ancestor_folder / name / path_in_package,
                *([ancestor_folder / path_in_package] if ancestor_folder.name == name else []),
            ]
        candidates += [folder / meshdir / PurePosixPath(path_in_package).name] if meshdir else []
        return next((path for path in candidates if is_file(path)), None)
    plain = text.removeprefix("file://")
    candidates = [folder / plain]
    candidates += [folder / meshdir / plain, folder / meshdir / PurePosixPath(plain).name] if meshdir else []
    return next((path for path in candidates if is_file(path)), candidates[0])


def _files_of_mjcf(document: ModelDocument) -> Iterator[NamedFile]:
    folder = document.path.parent
    settings: dict[str, str] = {}
    for compiler in document.root.iterfind("compiler"):
        settings |= compiler.attrib
    asset_folder = settings.get("assetdir", "")
    meshes, textures = settings.get("meshdir", asset_folder), settings.get("texturedir", asset_folder)
    strips_folders = settings.get("strippath") == "true"
    for element in document.root.iter("mesh", "hfield", "skin", "texture", "flexcomp", "model"):
        for attribute in ("file", *(_SIDE_ATTRIBUTES if element.tag == "texture" else ())):
            text = element.get(attribute, "")
            if not text.strip():
                continue
            plain = PurePosixPath(text).name if strips_folders else text
            subfolder = (
                meshes if element.tag in _MESH_FOLDER_TAGS else textures if element.tag == "texture" else ""
            )
            yield NamedFile(element, attribute, text, folder / subfolder / plain)
