"""Lists the files that an MJCF names, without MuJoCo, to notice when one changes.

Only MuJoCo reads the files. The list has every file on disk that an attribute `file...` may name, in any of
the folders that a `<compiler>` names. A file that MuJoCo does not use may be in the list: if it changes, a
build is repeated needlessly.
"""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from html import unescape
from itertools import chain, product
from pathlib import Path, PurePath

from linkwright.stages.formats import xml
from linkwright.stages.formats.mjcf.bounds import MAX_XML_BYTES
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.system import regular_files

LARGEST_FILE = 1 << 29
"""Largest size of a file [bytes]."""

LARGEST_MODEL = 1 << 32
"""Largest total size of a model's files [bytes]."""

_MAX_FILES = 20_000
"""Largest number of files that a model may name."""

_MAX_PATHS = 200_000
"""Largest number of paths that are looked up: file names times folders."""

_BINARY_SUFFIXES = (".stl", ".obj", ".msh", ".png", ".hdr", ".ply", ".dae", ".skn", ".bin", ".ktx")
_FIRST_TAG = re.compile(r"<([A-Za-z_][\w.-]*)")
_FILE = re.compile(r"""\bfile\w*\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_FOLDER = re.compile(r"""\b(?:meshdir|texturedir|assetdir)\s*=\s*(?:"([^"]*)"|'([^']*)')""")


@dataclass(frozen=True, slots=True)
class ModelFiles:
    """The files that a model may read."""

    digests: dict[str, str]
    """SHA-256 of the model's own file and of all files that it may read, by their paths from its folder."""

    texts: tuple[Path, ...]
    """The files that may be XML, the model's own first."""


def survey(path: Path) -> ModelFiles:
    """Lists the files of a model.

    Raises SourceError if its own file cannot be read or is not an MJCF, and if a file that it names is not a
    regular file, or is too large.
    """
    digest_of: dict[Path, str] = {}
    texts, count = [path], 0
    folders = {""}
    names: set[tuple[Path, str]] = set()
    size = 0
    while count < len(texts):
        file = texts[count]
        text = _own_text(path) if file == path else _text(file)
        count += 1
        digest_of[file] = sha256(text.encode()).hexdigest()
        new_folders = set(_values(_FOLDER, text)) - folders
        new_names = {(file.parent, name) for name in _values(_FILE, text)} - names
        folders |= new_folders
        if len(names) + len(new_names) > _MAX_FILES:
            raise _refused(path.name, f"it names more than {_MAX_FILES} files")
        if (len(names) + len(new_names)) * len(folders) > _MAX_PATHS:
            raise _refused(path.name, f"its file names and folders give more than {_MAX_PATHS} paths")
        for (naming_folder, name), folder in sorted(
            chain(product(new_names, folders), product(names, new_folders))
        ):
            for candidate in _possible_paths(path.parent, naming_folder, folder, name):
                if candidate in digest_of or not os.path.exists(candidate):  # noqa: PTH110
                    continue
                if regular_files.is_endless(candidate):
                    raise _refused(path.name, f"it names {name}: {regular_files.NOT_REGULAR}")
                if regular_files.is_file(candidate):
                    digest_of[candidate], length = _digest(path, candidate, name)
                    size += length
                    if candidate.suffix.lower() not in _BINARY_SUFFIXES and 0 < length <= MAX_XML_BYTES:
                        texts.append(candidate)
        names |= new_names
        if size > LARGEST_MODEL:
            raise _refused(path.name, f"its files have more than {LARGEST_MODEL / 1e9:.3g} GB")
    digests = {
        PurePath(os.path.relpath(file, path.parent)).as_posix(): digest_of[file] for file in sorted(digest_of)
    }
    return ModelFiles(digests, tuple(texts))


def _possible_paths(model_folder: Path, naming_folder: Path, folder: str, name: str) -> Iterator[Path]:
    """Yields the possible paths of a file: from the model's folder, from the folder of the file that names
    it, and both without the path in its name (`strippath`)."""
    for text in {name, PurePath(name.replace("\\", "/")).name} - {""}:
        yield from (Path(os.path.normpath(start / folder / text)) for start in {model_folder, naming_folder})


def _values(pattern: re.Pattern[str], text: str) -> Iterator[str]:
    return (unescape(double or single) for double, single in pattern.findall(text))


def _own_text(path: Path) -> str:
    """Returns the model's text. Raises SourceError if it is not text."""
    try:
        text = _text(path)
    except regular_files.FileTooLarge:
        raise _refused(path.name, f"it is longer than {MAX_XML_BYTES >> 20} MB") from None
    except OSError as error:
        msg = f"it cannot be read: {error.strerror or type(error).__name__}"
        raise SourceError(msg, path.name, "check source.path and its permissions") from None
    first = _FIRST_TAG.search(text)
    if first is None:
        raise _refused(
            path.name, "it is not XML", "source.path must name an MJCF, whose first element is <mujoco>"
        )
    if first[1] == "robot":
        raise _refused(path.name, "it is a URDF", "source=urdf reads a URDF")
    if first[1] != "mujoco":
        fault = f"is <{first[1]}>, expected" if _is_xml(text) else "is not"
        raise _refused(path.name, f"its first element {fault} <mujoco>")
    return text


def _is_xml(text: str) -> bool:
    """Tells whether a text without its comments is XML, so that a message may quote it."""
    try:
        xml.parse(text.encode("latin-1"))
    except xml.Malformed:
        return False
    return True


def _text(path: Path) -> str:
    """Returns a file's text without its comments."""
    text = regular_files.content(path, MAX_XML_BYTES).decode("latin-1").replace("\0", "")
    pieces, end = [], 0
    while (start := text.find("<!--", end)) >= 0:
        pieces.append(text[end:start])
        end = text.find("-->", start) + 3
        if end < 3:
            return "".join(pieces)
    return "".join([*pieces, text[end:]])


def _digest(path: Path, file: Path, name: str) -> tuple[str, int]:
    """Returns the SHA-256 of a file that the model `path` calls `name`, and its size [bytes]."""
    try:
        return regular_files.digest(file, LARGEST_FILE), file.stat().st_size
    except regular_files.FileTooLarge:
        raise _refused(path.name, f"it names {name}, which has more than {LARGEST_FILE >> 20} MB") from None
    except OSError:
        return "", 0  # MuJoCo reports an error if it needs the file


def _refused(name: str, why: str, hint: str = "check that source.path names the right file") -> SourceError:
    msg = f"not readable as an MJCF: {why}"
    return SourceError(msg, name, hint)
