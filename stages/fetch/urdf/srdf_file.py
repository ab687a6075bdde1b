"""Finds the SRDF of a URDF: the file that `source.srdf` names, or else a file of the robot's name in the
usual places."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from linkwright.stages.fetch.urdf import text
from linkwright.stages.robot.errors import ConfigError, Diagnostic, SourceError
from linkwright.stages.robot.system import regular_files

if TYPE_CHECKING:
    from linkwright.stages.fetch.urdf.section import UrdfSourceSection

SRDF = "robot.srdf"
"""The request for the SRDF's text."""

NAME_OPTION = "srdf"
"""The reader's option that holds the SRDF's name."""

AUTO, NONE = "auto", "none"

_CONFIG_KEY = "source.srdf"

_KIND = text.TextKind("an SRDF", _CONFIG_KEY, f"give an SRDF, or {_CONFIG_KEY}={NONE}")

_FOLDER = "srdf"
"""The folder of SRDFs in many packages, next to that of the URDF."""

_ENDINGS = (".xacro", ".urdf")


@dataclass(frozen=True, slots=True)
class SrdfFile:
    """An SRDF, or the reason why it is not read."""

    name: str
    """The name of the file in messages."""

    text: bytes = b""
    """The content in UTF-8."""

    why: str = ""
    """The reason why the file is not read, or ""."""

    def unread(self, why: str) -> Diagnostic:
        """Reports W-SRDF: the build goes on without the file."""
        hint = f"correct it, or build without it: {_CONFIG_KEY}={NONE}"
        return Diagnostic("W-SRDF", f"{why}: the robot is built without it", self.name, hint)


def is_named_by_user(source: UrdfSourceSection) -> bool:
    """Tells whether the configuration names the file."""
    return source.srdf not in (AUTO, NONE)


def require(source: UrdfSourceSection) -> None:
    """Raises ConfigError if the configuration names a missing file, or a xacro file."""
    if not is_named_by_user(source):
        return
    regular_files.require(source.srdf, _CONFIG_KEY, "an SRDF is a file", "robots/arm.srdf")
    if source.srdf.lower().endswith(".xacro"):
        msg = f"{source.srdf} is a xacro file, and only that of source.path is expanded"
        raise ConfigError(msg, _CONFIG_KEY, "expand it yourself: xacro FILE > robot.srdf")


def read(source: UrdfSourceSection, robot: str, folders: Mapping[str, str]) -> SrdfFile | None:
    """Returns the SRDF of a source, or None.

    `robot`: the name of the robot in the URDF; `folders`: folders of this computer → their replacements.
    Raises SourceError if the configuration names the file and it cannot be read.
    """
    place = _place(source, robot)
    if place is None:
        return None
    path, name = place
    try:
        content = text.read(path, name, _KIND)
    except SourceError as error:
        if is_named_by_user(source):
            raise
        return SrdfFile(name, why=error.message)
    return SrdfFile(name, text.without_folders(content, folders).encode())


def _place(source: UrdfSourceSection, robot: str) -> tuple[Path, str] | None:
    """Returns the path of the file, and its name in messages."""
    if source.srdf == NONE:
        return None
    if is_named_by_user(source):
        path = Path(source.srdf).absolute()
        return path, path.name
    urdf = Path(source.path).absolute()
    stem = urdf.name
    for ending in _ENDINGS:
        stem = stem[: -len(ending)] if stem.lower().endswith(ending) else stem
    names = [f"{name}.srdf" for name in (stem, robot) if name and Path(name).name == name]
    places = {
        file_name: folder / name
        for name in names
        for file_name, folder in (
            (name, urdf.parent),
            (f"../{_FOLDER}/{name}", urdf.parent.parent / _FOLDER),
        )
    }
    return next(
        ((path, file_name) for file_name, path in places.items() if regular_files.is_file(path)), None
    )
