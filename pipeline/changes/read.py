"""Reads the robot.json of an output folder, of a file, or of a revision in git."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from linkwright.pipeline.changes.git import read_blob
from linkwright.pipeline.errors import ConfigError, OutputError

ROBOT_FILE = "robot.json"
FORMAT, VERSION = "linkwright-robot", 1
_RENAMED_KEYS = {"mass": "total_mass"}
"""Keys in the files of earlier builds → their names now."""

_HINT = "give an output folder, its robot.json, or REV:path of git"


@dataclass(frozen=True, slots=True)
class SavedRobot:
    """A robot as its robot.json describes it."""

    place: str
    """The path as the user named it."""
    robot: Mapping[str, Any]
    """The content of robot.json."""
    is_folder: bool = False
    """Whether the path is the folder of a build."""


def read_robot(name: str) -> SavedRobot:
    """Reads the robot at a path, or at REV:path. Raises ConfigError for a wrong name; OutputError if there is
    no robot.json of a version that this program reads."""
    path = Path(name)
    if path.exists():
        file = path / ROBOT_FILE if path.is_dir() else path
        if not file.is_file():
            msg = f"the folder has no {ROBOT_FILE}"
            raise OutputError(msg, name, "a build leaves one; " + _HINT)
        return SavedRobot(name, _read(_bytes(file), str(file)), path.is_dir())
    revision, colon, inside = name.partition(":")
    if not colon or not revision:
        raise OutputError("there is no such file or folder", name, _HINT)
    return SavedRobot(name, _read(_from_git(name, revision, inside), name))


def _bytes(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise OutputError(f"it cannot be read: {error.strerror}", str(file)) from None


def _from_git(place: str, revision: str, inside: str) -> bytes:
    """Reads a file from git, or robot.json in a folder. The path may start at the repository's folder or at
    the working folder."""
    if revision.startswith("-"):
        raise ConfigError("a revision cannot begin with a dash", place, _HINT)
    relative_path = inside if inside.startswith(("./", "../")) else f"./{inside}"
    complaint = ""
    for path in (inside, relative_path):
        for inner in (path, str(PurePosixPath(path) / ROBOT_FILE) if inside else ROBOT_FILE):
            name = inner if path != relative_path or inner.startswith(("./", "../")) else f"./{inner}"
            process = read_blob(f"{revision}:{name}", _HINT)
            if process.returncode == 0:
                return process.stdout
            complaint = complaint or process.stderr.decode(errors="replace").strip()
    raise OutputError(
        f"git has no robot there: {complaint or 'it is a folder without ' + ROBOT_FILE}", place, _HINT
    )


def _read(data: bytes, place: str) -> Mapping[str, Any]:
    try:
        tree = json.loads(data)
    except ValueError as error:
        raise OutputError(f"it is not JSON: {error}", place, _HINT) from None
    if not isinstance(tree, dict) or tree.get("format") != FORMAT:
        raise OutputError(f"it is not a {ROBOT_FILE} of Linkwright", place, _HINT)
    if tree.get("version") != VERSION:
        msg = f"its version is {tree.get('version')}; this program reads version {VERSION}"
        raise OutputError(msg, place, "build it again, or use the Linkwright that made it")
    missing = [key for key in ("name", "links", "joints", "loops") if key not in tree]
    if missing:
        raise OutputError(f"it has no {' and no '.join(missing)}", place, "build it again")
    return in_new_keys(tree)


def in_new_keys(robot: Mapping[str, Any]) -> Mapping[str, Any]:
    """Returns the content of a robot.json of any build with the keys of this version."""
    return {_RENAMED_KEYS.get(key, key): value for key, value in robot.items()}
