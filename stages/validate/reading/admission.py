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

MODELS = (".urdf", ".xml", ".mjcf")
TEXTS = (*MODELS, ".srdf", ".sdf", ".usda", ".json", ".yaml", ".py", ".xacro", ".config")
TRUTH = "robot.json"

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

MAX_TRUTH_BYTES = 1 << 27
"""Largest size of a robot.json [bytes], enough for 20,000 links."""

_TEXTURES = ("texture", "hfield")
_SMALLER = "check that it is the file that you mean"


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
    models = sorted((path for path in visited if path.suffix.lower() in MODELS), reverse=True)
    pixels = 0
    while models:
        model = models.pop()
        _admit_included(model, sizes, visited)
        document = read(model)
        if document is None:
            continue
        _require_bounded(document)
        for file in referenced_files(document):
            if file.path is None or not _is_there(file.path) or file.path in visited:
                continue
            _admit(file.path, sizes, visited, document.path.name)
            if tag(file.element) == "model":
                models.append(file.path)
            if tag(file.element) in _TEXTURES:
                pixels += _pixels(file.path)
            if pixels > png.MAX_PIXELS:
                raise _refused(f"its images have more than {png.MAX_PIXELS} pixels", document.path.name)
    return sizes


def _files(place: Path) -> Iterator[Path]:
    """Yields the files of a build, if there is a robot.json; else the model, or the models in the folder."""
    if regular_files.is_special(place):
        raise _refused(regular_files.NOT_REGULAR, str(place))
    folder = place if place.is_dir() else place.parent
    truth = folder / TRUTH
    if truth.is_dir():
        raise _refused("it is a folder", str(truth))
    if truth.exists() or regular_files.is_special(truth):
        yield from _below(folder)
    elif place.is_dir():
        yield from (path for path in _entries(folder) if path.suffix.lower() in MODELS and not path.is_dir())
    elif place.exists():
        yield place


def _below(folder: Path) -> Iterator[Path]:
    """Yields the files of a folder and its subfolders. Links to folders are not followed."""
    waiting, seen = [folder], 0
    while waiting:
        for path in _entries(waiting.pop()):
            seen += 1
            if seen > MAX_FILES:
                raise _refused(f"it has more than {MAX_FILES} files", folder.name)
            if path.is_dir():
                waiting += [] if path.is_symlink() else [path]
            elif path.exists():
                yield path


def _admit_included(model: Path, sizes: Sizes, seen: set[Path]) -> None:
    """Admits the files that a model includes, directly or through other files: MuJoCo opens them whatever
    their kind."""
    admitted_paths = {model}

    def read(node: Element) -> Element | None:
        path = model.parent / node.get("file", "")
        if path in admitted_paths or not _is_there(path):
            return None
        admitted_paths.add(path)
        _admit(path, sizes, seen, model.name)
        return _parsed(path)

    root = _parsed(model)
    if root is not None:
        replace_includes(root, read)


def _parsed(path: Path) -> Element | None:
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


def _is_there(path: Path) -> bool:
    """Tells whether something other than a folder exists under a name that a file can have."""
    return regular_files.is_file(path) or regular_files.is_special(path)


def _admit(path: Path, sizes: Sizes, seen: set[Path], where: str) -> None:
    if path in seen:
        return
    seen.add(path)
    if len(seen) > MAX_FILES:
        raise _refused(f"it names more than {MAX_FILES} files", where)
    if regular_files.is_endless(path):
        raise _refused(f"{path.name}: {regular_files.NOT_REGULAR}", where)
    if not regular_files.is_file(path):
        return  # a check reports what is wrong with it
    size, text = path.stat().st_size, path.suffix.lower() in TEXTS
    limit = (MAX_TRUTH_BYTES if path.name == TRUTH else MAX_XML_BYTES) if text else MAX_ASSET_BYTES
    if size > limit:
        raise _refused(f"{path.name} is longer than {limit >> 20} MB", where)
    if text:
        sizes.texts += size
        _require_readable(path, limit, where)
    else:
        sizes.assets += size
    if sizes.texts + sizes.assets > MAX_TOTAL_BYTES:
        raise _refused(f"its files have more than {MAX_TOTAL_BYTES / 1e9:.3g} GB", where)


def _require_readable(path: Path, limit: int, where: str) -> None:
    """Raises SourceError if a text has more elements or tables than any robot."""
    try:
        data = regular_files.content(path, limit)
    except OSError:
        return  # a check reports it
    if sum(data.count(mark) for mark in (b"<", b"[", b"{")) > MAX_MARKS:
        raise _refused(f"{path.name} has more than {MAX_MARKS} elements or tables", where)


def _require_bounded(document: ModelDocument) -> None:
    """Raises SourceError if few bytes of the model would grow to a huge model."""
    name = document.path.name
    if document.language == "mjcf":
        mjcf_bounds.require_within_limits([document.path, *sorted(set(document.included.values()))])
    if sum(1 for _ in document.root.iter()) > MAX_ELEMENTS:
        raise _refused(f"it has more than {MAX_ELEMENTS} elements", name)
    _require_names(document.root.iter(), name)


def _require_names(elements: Iterable, where: str) -> None:  # type: ignore[type-arg]
    for element in elements:
        if len(element.get("name", "")) > mjcf_bounds.MAX_NAME_LENGTH:
            message = f"the name of a <{tag(element)}> has more than {mjcf_bounds.MAX_NAME_LENGTH} letters"
            raise _refused(message, where)


def _pixels(path: Path) -> int:
    """Returns the pixels of an image, by its header; 0 if it is no PNG."""
    try:
        with path.open("rb") as file:
            return png.pixels(file.read(24))
    except OSError:
        return 0


def _refused(why: str, where: str) -> SourceError:
    return SourceError(f"it is not checked: {why}", where, _SMALLER)
