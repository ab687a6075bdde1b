"""The files that an MJCF is made of, found without MuJoCo: what tells whether it changed.

MuJoCo alone reads them. Here every file on disk counts that an attribute `file...` may mean, in any of
the folders that a `<compiler>` names: one too many only makes the robot anew.
"""

import os
import re
from collections.abc import Iterator
from hashlib import file_digest, sha256
from html import unescape
from pathlib import Path, PurePath

from stages.robot.errors import SourceError

LARGEST_TEXT = 1 << 25
"""Longer XML is not read [bytes]: a model of 10,000 bodies has a tenth of that."""

_MOST_FILES = 20_000
_NO_TEXT = (".stl", ".obj", ".msh", ".png", ".hdr", ".ply", ".dae", ".skn", ".bin", ".ktx")
_FIRST = re.compile(r"<([A-Za-z_][\w.-]*)")
_FILE = re.compile(r"""\bfile\w*\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_FOLDER = re.compile(r"""\b(?:meshdir|texturedir|assetdir)\s*=\s*(?:"([^"]*)"|'([^']*)')""")


def digests(path: Path) -> dict[str, str]:
    """SHA-256 of the model's own file and of all that it may read, by their paths from its folder.

    SourceError where the file cannot be read, or is no MJCF.
    """
    home = path.parent
    found = {path: ""}
    texts = [path]
    folders = {""}
    wanted: set[tuple[Path, str]] = set()
    while texts:
        one = texts.pop()
        text = _text(one) if one != path else _own_text(path)
        found[one] = sha256(text.encode()).hexdigest()
        folders |= set(_values(_FOLDER, text))
        wanted |= {(one.parent, name) for name in _values(_FILE, text)}
        if len(wanted) > _MOST_FILES:
            raise _refused(path.name, f"it names more than {_MOST_FILES} files")
        for candidate in sorted({c for beside, name in wanted for c in _places(home, folders, beside, name)}):
            # Path.is_file fails on a name that is too long for one.
            if candidate not in found and os.path.isfile(candidate):  # noqa: PTH113
                found[candidate] = _digest(candidate)
                if found[candidate] and candidate.suffix.lower() not in _NO_TEXT:
                    texts.append(candidate)
    return {PurePath(os.path.relpath(one, home)).as_posix(): found[one] for one in sorted(found)}


def _places(home: Path, folders: set[str], beside: Path, name: str) -> Iterator[Path]:
    """Where a file may be: from the model's folder, that of the file which names it, or without its own
    path (`strippath`)."""
    for text in {name, PurePath(name.replace("\\", "/")).name} - {""}:
        for start in {home, beside}:
            yield from (Path(os.path.normpath(start / folder / text)) for folder in folders)


def _values(pattern: re.Pattern[str], text: str) -> Iterator[str]:
    return (unescape(one or other) for one, other in pattern.findall(text))


def _own_text(path: Path) -> str:
    """The model's text; SourceError where it is none."""
    try:
        if path.stat().st_size > LARGEST_TEXT:
            raise _refused(path.name, f"it is longer than {LARGEST_TEXT >> 20} MB")
        text = _text(path)
    except OSError as error:
        msg = f"it cannot be read: {error.strerror or type(error).__name__}"
        raise SourceError(msg, path.name, "check source.path and its permissions") from None
    first = _FIRST.search(text)
    if first is None:
        raise _refused(path.name, "it is no XML", "source.path is an MJCF, whose first element is <mujoco>")
    if first[1] == "robot":
        raise _refused(path.name, "it is a URDF", "source=urdf reads those")
    if first[1] != "mujoco":
        raise _refused(path.name, f"its first element is <{first[1]}>", "an MJCF's is <mujoco>")
    return text


def _text(path: Path) -> str:
    """A file's text without its comments."""
    text = path.read_bytes().decode("latin-1").replace("\0", "")
    pieces, end = [], 0
    while (start := text.find("<!--", end)) >= 0:
        pieces.append(text[end:start])
        end = text.find("-->", start) + 3
        if end < 3:
            return "".join(pieces)
    return "".join([*pieces, text[end:]])


def _digest(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""  # MuJoCo says what is wrong with it, if it wants it


def _refused(name: str, why: str, hint: str = "check that source.path names the right file") -> SourceError:
    msg = f"not readable as an MJCF: {why}"
    return SourceError(msg, name, hint)
