"""Decides which files the checks read, and refuses files that are not regular, too large or too many.

MuJoCo opens files by itself and waits for a pipe forever; a few bytes of a header or of XML may grow to
gigabytes.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from linkwright.stages.formats import png
from linkwright.stages.formats.mjcf import bounds as mjcf_bounds
from linkwright.stages.formats.mjcf.bounds import MAX_XML_BYTES
from linkwright.stages.formats.xml import Element, Malformed, parse, tag
from linkwright.stages.mujoco.includes import replace_includes
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.system import regular_files
from linkwright.stages.validate.reading.asset_files import referenced_files
from linkwright.stages.validate.reading.documents import ModelDocument, read

MODEL_ENDINGS = (".urdf", ".xml", ".mjcf")
"""Endings of the files that are read as models."""

TEXT_ENDINGS = (*MODEL_ENDINGS, ".srdf", ".sdf", ".usda", ".json", ".yaml", ".py", ".xacro", ".config")
"""Endings of texts; any other file is a mesh or an image."""

ROBOT_JSON = "robot.json"
"""The file that makes a folder that of a build."""

MAX_ASSET_BYTES = 1 << 28
"""Largest size of a mesh or an image [bytes]."""

MAX_TOTAL_BYTES = 1 << 30
"""Largest size of all files [bytes]."""

MAX_FILES = 20_000
"""Largest number of files in a folder, and of files that models name."""

MAX_ELEMENTS = 200_000
"""Largest number of elements of a URDF or MJCF, enough for 20,000 links."""

MAX_MARKS = 2_000_000
"""Largest number of characters that begin an element or a table: each takes at least a hundred bytes of
memory."""

MAX_ROBOT_JSON_BYTES = 1 << 27
"""Largest size of a robot.json [bytes], enough for 20,000 links."""

_IMAGE_TAGS = ("texture", "hfield")
"""Elements of an MJCF whose files are images."""

_HINT = "check that it is the file that you mean"


@dataclass(slots=True)
class Sizes:
    """The sizes of the files that are read."""

    texts: int = 0
    """Bytes of all texts."""

    assets: int = 0
    """Bytes of all meshes and images."""


def admitted(place: Path) -> Sizes:
    """Returns the sizes of the files that the checks of a folder or file read. Raises SourceError if a file
    is not a regular file, is too large, or would become too large in memory."""
    sizes, visited = Sizes(), set[Path]()
    for path in _files(place):
        _admit(path, sizes, visited, path.name)
    # In order, so that of several faults always the same one is reported.
    models = sorted((path for path in visited if path.suffix.lower() in MODEL_ENDINGS), reverse=True)
    pixels = 0
    while models:
        model = models.pop()
        _admit_included(model, sizes, visited)
        document = read(model)
        if document is None:
            continue
        _require_bounded(document)
        for file in referenced_files(document):
            if file.path is None or not _exists(file.path) or file.path in visited:
                continue
            _admit(file.path, sizes, visited, document.path.name)
            if tag(file.element) == "model":
                models.append(file.path)
            if tag(file.element) in _IMAGE_TAGS:
                pixels += _pixel_count(file.path)
            if pixels > png.MAX_PIXELS:
                raise _refusal(f"its images have more than {png.MAX_PIXELS} pixels", document.path.name)
    return sizes


def _files(place: Path) -> Iterator[Path]:
    """Yields the files of a build, if there is a robot.json; else the model, or the models in the folder."""
    if regular_files.is_special(place):
        raise _refusal(regular_files.NOT_REGULAR, str(place))
    folder = place if place.is_dir() else place.parent
    robot_json = folder / ROBOT_JSON
    if robot_json.is_dir():
        raise _refusal("it is a folder", str(robot_json))
    if robot_json.exists() or regular_files.is_special(robot_json):
        yield from _files_below(folder)
    elif place.is_dir():
        yield from (
            path for path in _entries(folder) if path.suffix.lower() in MODEL_ENDINGS and not path.is_dir()
        )
    elif place.exists():
        yield place


def _files_below(folder: Path) -> Iterator[Path]:
    """Yields the files of a folder and its subfolders. Links to folders are not followed."""
    folders, entry_count = [folder], 0
    while folders:
        for path in _entries(folders.pop()):
            entry_count += 1
            if entry_count > MAX_FILES:
                raise _refusal(f"it has more than {MAX_FILES} files", folder.name)
            if path.is_dir():
                folders += [] if path.is_symlink() else [path]
            elif path.exists():
                yield path


def _admit_included(model: Path, sizes: Sizes, visited_paths: set[Path]) -> None:
    """Admits the files that a model includes, directly or through other files: MuJoCo opens them whatever
    their kind."""
    admitted_paths = {model}

    def included_root(node: Element) -> Element | None:
        path = model.parent / node.get("file", "")
        if path in admitted_paths or not _exists(path):
            return None
        admitted_paths.add(path)
        _admit(path, sizes, visited_paths, model.name)
        return _parsed(path)

    root = _parsed(model)
    if root is not None:
        replace_includes(root, included_root)


def _parsed(path: Path) -> Element | None:
    """Returns the root of a file; None if the file cannot be read."""
    try:
        return parse(regular_files.content(path, MAX_XML_BYTES))
    except (Malformed, OSError, regular_files.FileTooLarge):
        return None  # a check reports it


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError as error:
        msg = f"it cannot be read: {error.strerror or type(error).__name__}"
        raise SourceError(msg, str(folder)) from None


def _exists(path: Path) -> bool:
    """Tells whether something other than a folder exists under a name that a file can have."""
    return regular_files.is_file(path) or regular_files.is_special(path)


def _admit(path: Path, sizes: Sizes, visited_paths: set[Path], where: str) -> None:
    """Adds the size of a file to `sizes`. Raises SourceError if the file is endless or too large,
    or if all files together are too many or too large. `where`: the file that the error is about."""
    if path in visited_paths:
        return
    visited_paths.add(path)
    if len(visited_paths) > MAX_FILES:
        raise _refusal(f"it names more than {MAX_FILES} files", where)
    if regular_files.is_endless(path):
        raise _refusal(f"{path.name}: {regular_files.NOT_REGULAR}", where)
    if not regular_files.is_file(path):
        return  # a check reports what is wrong with it
    size, text = path.stat().st_size, path.suffix.lower() in TEXT_ENDINGS
    limit = (MAX_ROBOT_JSON_BYTES if path.name == ROBOT_JSON else MAX_XML_BYTES) if text else MAX_ASSET_BYTES
    if size > limit:
        raise _refusal(f"{path.name} is longer than {limit >> 20} MB", where)
    if text:
        sizes.texts += size
        _require_readable(path, limit, where)
    else:
        sizes.assets += size
    if sizes.texts + sizes.assets > MAX_TOTAL_BYTES:
        raise _refusal(f"its files have more than {MAX_TOTAL_BYTES / 1e9:.3g} GB", where)


def _require_readable(path: Path, limit: int, where: str) -> None:
    """Raises SourceError if a text has more elements or tables than any robot."""
    try:
        data = regular_files.content(path, limit)
    except OSError:
        return  # a check reports it
    if sum(data.count(mark) for mark in (b"<", b"[", b"{")) > MAX_MARKS:
        raise _refusal(f"{path.name} has more than {MAX_MARKS} elements or tables", where)


def _require_bounded(document: ModelDocument) -> None:
    """Raises SourceError if few bytes of the model would grow to a huge model."""
    name = document.path.name
    if document.language == "mjcf":
        mjcf_bounds.require_within_limits([document.path, *sorted(set(document.included.values()))])
    if sum(1 for _ in document.root.iter()) > MAX_ELEMENTS:
        raise _refusal(f"it has more than {MAX_ELEMENTS} elements", name)
    _require_names(document.root.iter(), name)


def _require_names(elements: Iterable, where: str) -> None:  # type: ignore[type-arg]
    for element in elements:
        if len(element.get("name", "")) > mjcf_bounds.MAX_NAME_LENGTH:
            message = f"the name of a <{tag(element)}> has more than {mjcf_bounds.MAX_NAME_LENGTH} letters"
            raise _refusal(message, where)


def _pixel_count(path: Path) -> int:
    """Returns the number of pixels of an image, from its header; 0 if the file is not a PNG."""
    try:
        with path.open("rb") as file:
            return png.pixel_count(file.read(24))
    except OSError:
        return 0


def _refusal(why: str, where: str) -> SourceError:
    """Returns the error for a file or folder (`where`) that is not read."""
    return SourceError(f"it is not checked: {why}", where, _HINT)
