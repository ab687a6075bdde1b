"""Finds the SRDF of a URDF: the file that `source.srdf` names, else one of its name in the usual places."""

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
"""The request that stands for the SRDF's text."""

NAME = "srdf"
"""The reader's option that has the SRDF's name."""

AUTO, NONE = "auto", "none"

_KEY = "source.srdf"

_KIND = text.TextKind("an SRDF", _KEY, f"give an SRDF, or {_KEY}={NONE}")

_FOLDER = "srdf"
"""Where many packages have it, beside the folder of the URDF."""

_ENDINGS = (".xacro", ".urdf")


@dataclass(frozen=True, slots=True)
class SrdfFile:
    """An SRDF. `name`: as messages call it; `text`: in UTF-8; `why`: the reason why it is not read, "" where
    it is."""

    name: str
    text: bytes = b""
    why: str = ""

    def unread(self, why: str) -> Diagnostic:
        """W-SRDF: the build goes on without it."""
        hint = f"correct it, or build without it: {_KEY}={NONE}"
        return Diagnostic("W-SRDF", f"{why}: the robot is built without it", self.name, hint)


def is_asked(source: UrdfSourceSection) -> bool:
    """Whether the configuration names the file."""
    return source.srdf not in (AUTO, NONE)


def require(source: UrdfSourceSection) -> None:
    """ConfigError where the configuration names a file that is not there, or a xacro file."""
    if not is_asked(source):
        return
    regular_files.require(source.srdf, _KEY, "an SRDF is a file", "robots/arm.srdf")
    if source.srdf.lower().endswith(".xacro"):
        msg = f"{source.srdf} is a xacro file, and only that of source.path is expanded"
        raise ConfigError(msg, _KEY, "expand it yourself: xacro FILE > robot.srdf")


def read(source: UrdfSourceSection, robot: str, folders: Mapping[str, str]) -> SrdfFile | None:
    """The SRDF of a source; None without one. `robot`: the name of the robot in the URDF; `folders`: of this
    computer, and what stands for them.

    SourceError where the configuration names it and it cannot be read.
    """
    found = _place(source, robot)
    if found is None:
        return None
    path, name = found
    try:
        content = text.read(path, name, _KIND)
    except SourceError as error:
        if is_asked(source):
            raise
        return SrdfFile(name, why=error.message)
    return SrdfFile(name, text.without(content, folders).encode())


def _place(source: UrdfSourceSection, robot: str) -> tuple[Path, str] | None:
    """The file, and its name in messages."""
    if source.srdf == NONE:
        return None
    if is_asked(source):
        path = Path(source.srdf).absolute()
        return path, path.name
    urdf = Path(source.path).absolute()
    stem = urdf.name
    for ending in _ENDINGS:
        stem = stem[: -len(ending)] if stem.lower().endswith(ending) else stem
    names = [f"{name}.srdf" for name in (stem, robot) if name and Path(name).name == name]
    places = {
        shown: folder / name
        for name in names
        for shown, folder in (
            (name, urdf.parent),
            (f"../{_FOLDER}/{name}", urdf.parent.parent / _FOLDER),
        )
    }
    return next(((path, shown) for shown, path in places.items() if regular_files.is_file(path)), None)
