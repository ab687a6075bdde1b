"""The files that a model names: meshes, textures and height fields, and where they lie."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.system.regular_files import is_file
from linkwright.stages.validate.reading.documents import ModelDocument

_MESH_FOLDER = ("mesh", "hfield", "skin", "flexcomp")
"""Elements of an MJCF whose files lie in the compiler's `meshdir`."""

_SIDES = tuple(f"file{side}" for side in ("back", "down", "front", "left", "right", "up"))


@dataclass(frozen=True, slots=True, eq=False)
class NamedFile:
    """A file that an element names by an attribute, as `text`. `path`: where it lies, None where no folder is
    known for the package that it names."""

    element: Element
    attribute: str
    text: str
    path: Path | None


def named_files(document: ModelDocument) -> Iterator[NamedFile]:
    """Every file that the model, with what it includes, names."""
    if document.language == "urdf":
        yield from _of_urdf(document)
    else:
        yield from _of_mjcf(document)


def package_of(text: str) -> str:
    """The package that a path begins with; "" for a plain path."""
    return text.partition("://")[2].partition("/")[0] if is_of_package(text) else ""


def is_of_package(text: str) -> bool:
    """Whether a path counts from the folder of a package, which may be left out as in `package:///a.stl`."""
    return text.startswith(("package://", "model://"))


def _of_urdf(document: ModelDocument) -> Iterator[NamedFile]:
    folder = document.path.parent
    (meshdir,) = [one.get("meshdir", "") for one in document.root.iterfind("mujoco/compiler")][:1] or [""]
    for element in document.root.iter("mesh", "texture"):
        text = element.get("filename", "")
        if not text.strip() or any("ros2_control" in tag(one) for one in element.iterancestors()):
            continue
        yield NamedFile(element, "filename", text, _place(text, folder, meshdir, document.packages))


def _place(text: str, folder: Path, meshdir: str, packages: tuple[str, ...] | None) -> Path | None:
    """Where a path of a URDF leads: from its own folder, or from the folder of the package. `packages`: those
    that its own folder may be, None for any."""
    if is_of_package(text):
        name = package_of(text)
        rest = unquote(text.partition("://")[2].partition("/")[2])
        tries = [folder / rest] if packages is None or name in packages else []
        for above in (folder.resolve(), *folder.resolve().parents):
            tries += [above / name / rest, *([above / rest] if above.name == name else [])]
        tries += [folder / meshdir / PurePosixPath(rest).name] if meshdir else []
        return next((one for one in tries if is_file(one)), None)
    plain = text.removeprefix("file://")
    tries = [folder / plain]
    tries += [folder / meshdir / plain, folder / meshdir / PurePosixPath(plain).name] if meshdir else []
    return next((one for one in tries if is_file(one)), tries[0])


def _of_mjcf(document: ModelDocument) -> Iterator[NamedFile]:
    folder = document.path.parent
    settings: dict[str, str] = {}
    for compiler in document.root.iterfind("compiler"):
        settings |= compiler.attrib
    both = settings.get("assetdir", "")
    meshes, textures = settings.get("meshdir", both), settings.get("texturedir", both)
    strip = settings.get("strippath") == "true"
    for element in document.root.iter("mesh", "hfield", "skin", "texture", "flexcomp", "model"):
        for attribute in ("file", *(_SIDES if element.tag == "texture" else ())):
            text = element.get(attribute, "")
            if not text.strip():
                continue
            plain = PurePosixPath(text).name if strip else text
            inside = meshes if element.tag in _MESH_FOLDER else textures if element.tag == "texture" else ""
            yield NamedFile(element, attribute, text, folder / inside / plain)
