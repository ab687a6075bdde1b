"""The files that an MJCF names, found without MuJoCo, to notice when one changes.

Only MuJoCo reads them. Here every file on disk counts that an attribute `file...` may name, in any of
the folders that a `<compiler>` names: a file too many only causes a needless build.
"""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from html import unescape
from itertools import chain, product
from pathlib import Path, PurePath

from linkwright.stages.formats.mjcf.bounds import LARGEST_TEXT
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.system import regular_files

LARGEST_FILE = 1 << 29
"""Largest size of one file [bytes]."""

LARGEST_MODEL = 1 << 32
"""Largest total size of a model's files [bytes]."""

_MOST_FILES = 20_000
_MOST_PLACES = 200_000
"""Largest number of paths that are looked up: file names times folders."""

_NO_TEXT = (".stl", ".obj", ".msh", ".png", ".hdr", ".ply", ".dae", ".skn", ".bin", ".ktx")
_FIRST = re.compile(r"<([A-Za-z_][\w.-]*)")
_FILE = re.compile(r"""\bfile\w*\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_FOLDER = re.compile(r"""\b(?:meshdir|texturedir|assetdir)\s*=\s*(?:"([^"]*)"|'([^']*)')""")


@dataclass(frozen=True, slots=True)
class ModelFiles:
    """`digests`: SHA-256 of the model's own file and of all files that it may read, by their paths from its
    folder; `texts`: the files that may be XML, the model's own first."""

    digests: dict[str, str]
    texts: tuple[Path, ...]


def survey(path: Path) -> ModelFiles:
    """The files of a model. SourceError where its own file cannot be read or is not an MJCF, and where a file
    that it names is not a regular file, or is too large."""
    found: dict[Path, str] = {}
    texts, seen = [path], 0
    folders = {""}
    wanted: set[tuple[Path, str]] = set()
    size = 0
    while seen < len(texts):
        one = texts[seen]
        text = _own_text(path) if one == path else _text(one)
        seen += 1
        found[one] = sha256(text.encode()).hexdigest()
        new_folders = set(_values(_FOLDER, text)) - folders
        new = {(one.parent, name) for name in _values(_FILE, text)} - wanted
        folders |= new_folders
        if len(wanted) + len(new) > _MOST_FILES:
            raise _refused(path.name, f"it names more than {_MOST_FILES} files")
        if (len(wanted) + len(new)) * len(folders) > _MOST_PLACES:
            raise _refused(path.name, f"its file names and folders give more than {_MOST_PLACES} paths")
        for (beside, name), folder in sorted(chain(product(new, folders), product(wanted, new_folders))):
            for candidate in _places(path.parent, beside, folder, name):
                if candidate in found or not os.path.exists(candidate):  # noqa: PTH110
                    continue
                if regular_files.is_endless(candidate):
                    raise _refused(path.name, f"it names {name}: {regular_files.NOT_REGULAR}")
                if regular_files.is_file(candidate):
                    found[candidate], length = _digest(path, candidate, name)
                    size += length
                    if candidate.suffix.lower() not in _NO_TEXT and 0 < length <= LARGEST_TEXT:
                        texts.append(candidate)
        wanted |= new
        if size > LARGEST_MODEL:
            raise _refused(path.name, f"its files have more than {LARGEST_MODEL / 1e9:.3g} GB")
    digests = {PurePath(os.path.relpath(one, path.parent)).as_posix(): found[one] for one in sorted(found)}
    return ModelFiles(digests, tuple(texts))


def _places(home: Path, beside: Path, folder: str, name: str) -> Iterator[Path]:
    """Where a file may be: from the model's folder, that of the file which names it, or without its own
    path (`strippath`)."""
    for text in {name, PurePath(name.replace("\\", "/")).name} - {""}:
        yield from (Path(os.path.normpath(start / folder / text)) for start in {home, beside})


def _values(pattern: re.Pattern[str], text: str) -> Iterator[str]:
    return (unescape(one or other) for one, other in pattern.findall(text))


def _own_text(path: Path) -> str:
    """The model's text; SourceError where it is not text."""
    try:
        text = _text(path)
    except regular_files.FileTooLarge:
        raise _refused(path.name, f"it is longer than {LARGEST_TEXT >> 20} MB") from None
    except OSError as error:
        msg = f"it cannot be read: {error.strerror or type(error).__name__}"
        raise SourceError(msg, path.name, "check source.path and its permissions") from None
    first = _FIRST.search(text)
    if first is None:
        raise _refused(
            path.name, "it is not XML", "source.path must name an MJCF, whose first element is <mujoco>"
        )
    if first[1] == "robot":
        raise _refused(path.name, "it is a URDF", "source=urdf reads a URDF")
    if first[1] != "mujoco":
        named = f"is <{first[1]}>, expected" if _is_xml(text) else "is not"
        raise _refused(path.name, f"its first element {named} <mujoco>")
    return text


def _is_xml(text: str) -> bool:
    """Whether a text without its comments is XML, so that a message may quote it."""
    # Late: an unchanged source is not read again.
    from linkwright.stages.formats import xml

    try:
        xml.parse(text.encode("latin-1"))
    except xml.Malformed:
        return False
    return True


def _text(path: Path) -> str:
    """A file's text without its comments."""
    text = regular_files.content(path, LARGEST_TEXT).decode("latin-1").replace("\0", "")
    pieces, end = [], 0
    while (start := text.find("<!--", end)) >= 0:
        pieces.append(text[end:start])
        end = text.find("-->", start) + 3
        if end < 3:
            return "".join(pieces)
    return "".join([*pieces, text[end:]])


def _digest(path: Path, file: Path, name: str) -> tuple[str, int]:
    """The SHA-256 of a file that the model `path` calls `name`, and its size [bytes]."""
    try:
        return regular_files.digest(file, LARGEST_FILE), file.stat().st_size
    except regular_files.FileTooLarge:
        raise _refused(path.name, f"it names {name}, which has more than {LARGEST_FILE >> 20} MB") from None
    except OSError:
        return "", 0  # MuJoCo reports what is wrong with it, if it wants it


def _refused(name: str, why: str, hint: str = "check that source.path names the right file") -> SourceError:
    msg = f"not readable as an MJCF: {why}"
    return SourceError(msg, name, hint)
