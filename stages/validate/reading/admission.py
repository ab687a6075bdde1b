"""Which files the checks read, and whether they may: only regular files, of bounded sizes and counts.

MuJoCo opens files by itself and waits for a pipe for ever; a few bytes of a header or of XML make gigabytes.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from linkwright.stages.formats import png
from linkwright.stages.formats.mjcf import bounds as mjcf_bounds
from linkwright.stages.formats.mjcf.bounds import LARGEST_TEXT
from linkwright.stages.formats.xml import Element, Malformed, parse, tag
from linkwright.stages.mujoco.includes import resolve
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.system import regular_files
from linkwright.stages.validate.reading.asset_files import named_files
from linkwright.stages.validate.reading.documents import ModelDocument, read

MODELS = (".urdf", ".xml", ".mjcf")
TEXTS = (*MODELS, ".srdf", ".sdf", ".usda", ".json", ".yaml", ".py", ".xacro", ".config")
TRUTH = "robot.json"

LARGEST_ASSET = 1 << 28
"""Largest size of a mesh or an image [bytes]."""

LARGEST = 1 << 30
"""Largest size of all files [bytes]."""

MOST_FILES = 20_000

MOST_ELEMENTS = 200_000
"""Elements of a URDF or MJCF: with 20,000 links and what they have."""

MOST_MARKS = 2_000_000
"""Characters of a text that begin an element or a table: each takes a hundred bytes of memory and more."""

LARGEST_TRUTH = 1 << 27
"""Largest size of a robot.json [bytes]: of 20,000 links."""

_TEXTURES = ("texture", "hfield")
_SMALLER = "check that it is the file that you mean"


@dataclass(slots=True)
class Sizes:
    """Bytes of all texts, and of all meshes and images."""

    texts: int = 0
    assets: int = 0


def admitted(place: Path) -> Sizes:
    """The sizes of the files that the checks of a folder or file read. SourceError where one of these is no
    regular file, or too large, or would become so in memory."""
    sizes, seen = Sizes(), set[Path]()
    for path in _files(place):
        _admit(path, sizes, seen, path.name)
    models = [path for path in seen if path.suffix.lower() in MODELS]
    pixels = 0
    while models:
        model = models.pop()
        _admit_included(model, sizes, seen)
        document = read(model)
        if document is None:
            continue
        _require_bounded(document)
        for named in named_files(document):
            if named.path is None or not _is_there(named.path) or named.path in seen:
                continue
            _admit(named.path, sizes, seen, document.path.name)
            if tag(named.element) == "model":
                models.append(named.path)
            if tag(named.element) in _TEXTURES:
                pixels += _pixels(named.path)
            if pixels > png.MOST_PIXELS:
                raise _refused(f"its images have more than {png.MOST_PIXELS} pixels", document.path.name)
    return sizes


def _files(place: Path) -> Iterator[Path]:
    """The files of a build, which has a robot.json; else the model, or the models in the folder."""
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
    """The files of a folder and of the folders in it, but for links to other folders."""
    waiting, seen = [folder], 0
    while waiting:
        for path in _entries(waiting.pop()):
            seen += 1
            if seen > MOST_FILES:
                raise _refused(f"it has more than {MOST_FILES} files", folder.name)
            if path.is_dir():
                waiting += [] if path.is_symlink() else [path]
            elif path.exists():
                yield path


def _admit_included(model: Path, sizes: Sizes, seen: set[Path]) -> None:
    """Admits what a model includes, and what that includes, as MuJoCo opens it, whatever it is."""
    own = {model}

    def read(node: Element) -> Element | None:
        path = model.parent / node.get("file", "")
        if path in own or not _is_there(path):
            return None
        own.add(path)
        _admit(path, sizes, seen, model.name)
        return _parsed(path)

    root = _parsed(model)
    if root is not None:
        resolve(root, read)


def _parsed(path: Path) -> Element | None:
    try:
        return parse(regular_files.content(path, LARGEST_TEXT))
    except (Malformed, OSError, regular_files.FileTooLarge):
        return None  # a check says so


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError as error:
        msg = f"it cannot be read: {error.strerror or type(error).__name__}"
        raise SourceError(msg, str(folder)) from None


def _is_there(path: Path) -> bool:
    """Whether something that is no folder is there, by a name that a file can have."""
    return regular_files.is_file(path) or regular_files.is_special(path)


def _admit(path: Path, sizes: Sizes, seen: set[Path], where: str) -> None:
    if path in seen:
        return
    seen.add(path)
    if len(seen) > MOST_FILES:
        raise _refused(f"it names more than {MOST_FILES} files", where)
    if regular_files.is_endless(path):
        raise _refused(f"{path.name}: {regular_files.NOT_REGULAR}", where)
    if not regular_files.is_file(path):
        return  # a check says what is wrong with it
    size, text = path.stat().st_size, path.suffix.lower() in TEXTS
    most = (LARGEST_TRUTH if path.name == TRUTH else LARGEST_TEXT) if text else LARGEST_ASSET
    if size > most:
        raise _refused(f"{path.name} is longer than {most >> 20} MB", where)
    if text:
        sizes.texts += size
        _require_readable(path, most, where)
    else:
        sizes.assets += size
    if sizes.texts + sizes.assets > LARGEST:
        raise _refused(f"its files have more than {LARGEST / 1e9:.3g} GB", where)


def _require_readable(path: Path, most: int, where: str) -> None:
    """SourceError where a text has more elements or tables than any robot."""
    try:
        data = regular_files.content(path, most)
    except OSError:
        return  # a check says so
    if sum(data.count(mark) for mark in (b"<", b"[", b"{")) > MOST_MARKS:
        raise _refused(f"{path.name} has more than {MOST_MARKS} elements or tables", where)


def _require_bounded(document: ModelDocument) -> None:
    """SourceError where few bytes of the model would become a huge one."""
    name = document.path.name
    if document.language == "mjcf":
        mjcf_bounds.require(document.path, [document.path, *sorted(set(document.included.values()))])
    if sum(1 for _ in document.root.iter()) > MOST_ELEMENTS:
        raise _refused(f"it has more than {MOST_ELEMENTS} elements", name)
    _require_names(document.root.iter(), name)


def _require_names(elements: Iterable, where: str) -> None:  # type: ignore[type-arg]
    for element in elements:
        if len(element.get("name", "")) > mjcf_bounds.MOST_LETTERS:
            words = f"the name of a <{tag(element)}> has more than {mjcf_bounds.MOST_LETTERS} letters"
            raise _refused(words, where)


def _pixels(path: Path) -> int:
    """The pixels of an image, as its header has them; 0 where it is no PNG."""
    try:
        with path.open("rb") as file:
            return png.pixels(file.read(24))
    except OSError:
        return 0


def _refused(why: str, where: str) -> SourceError:
    return SourceError(f"it is not checked: {why}", where, _SMALLER)
