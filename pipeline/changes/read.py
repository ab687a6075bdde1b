"""Reads the robot.json of an output folder, of a file, or of a revision in git."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from linkwright.pipeline.changes.git import blob
from linkwright.pipeline.errors import ConfigError, OutputError

FILE = "robot.json"
FORMAT, VERSION = "linkwright-robot", 1
_HINT = "give an output folder, its robot.json, or REV:path of git"


@dataclass(frozen=True, slots=True)
class Described:
    """A robot as its robot.json describes it; `place`: where that is, for the user; `folder`: whether that is
    the folder of a build."""

    place: str
    robot: Mapping[str, Any]
    folder: bool = False


def described(asked: str) -> Described:
    """The robot at a path, or at REV:path. ConfigError where nothing is there; OutputError where what is
    there is no robot.json of a version that this program reads."""
    path = Path(asked)
    if path.exists():
        file = path / FILE if path.is_dir() else path
        if not file.is_file():
            msg = f"the folder has no {FILE}"
            raise OutputError(msg, asked, "a build leaves one; " + _HINT)
        return Described(asked, _read(_bytes(file), str(file)), path.is_dir())
    revision, colon, inside = asked.partition(":")
    if not colon or not revision:
        raise OutputError("there is no such file or folder", asked, _HINT)
    return Described(asked, _read(_from_git(asked, revision, inside), asked))


def _bytes(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise OutputError(f"it cannot be read: {error.strerror}", str(file)) from None


def _from_git(asked: str, revision: str, inside: str) -> bytes:
    """The file at a path from the folder of the repository or from here, or in the folder at that path."""
    if revision.startswith("-"):
        raise ConfigError("a revision cannot begin with a dash", asked, _HINT)
    here = inside if inside.startswith(("./", "../")) else f"./{inside}"
    said = ""
    for path in (inside, here):
        for one in (path, str(PurePosixPath(path) / FILE) if inside else FILE):
            name = one if path != here or one.startswith(("./", "../")) else f"./{one}"
            found = blob(f"{revision}:{name}", _HINT)
            if found.returncode == 0:
                return found.stdout
            said = said or found.stderr.decode(errors="replace").strip()
    raise OutputError(f"git has no robot there: {said or 'it is a folder without ' + FILE}", asked, _HINT)


def _read(data: bytes, place: str) -> Mapping[str, Any]:
    try:
        found = json.loads(data)
    except ValueError as error:
        raise OutputError(f"it is no JSON: {error}", place, _HINT) from None
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise OutputError(f"it is no {FILE} of Linkwright", place, _HINT)
    if found.get("version") != VERSION:
        msg = f"its version is {found.get('version')}; this program reads version {VERSION}"
        raise OutputError(msg, place, "build it again, or use the Linkwright that made it")
    missing = [key for key in ("name", "links", "joints", "loops") if key not in found]
    if missing:
        raise OutputError(f"it has no {' and no '.join(missing)}", place, "build it again")
    return found
