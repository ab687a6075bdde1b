"""Finds the folders of ROS packages."""

from __future__ import annotations

import functools
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from linkwright.stages.robot.system import regular_files

_NAME = re.compile(rb"<name>\s*([^<\s]+)\s*</name>")
_OF_ROS = ("ROS_PACKAGE_PATH", "GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH")
_AMENT = "AMENT_PREFIX_PATH"
VARIABLES = (*_OF_ROS, _AMENT)
"""ROS's own variables of the environment: the paths on which packages lie."""

_LARGEST = 1 << 20
"""Larger files are no package.xml [bytes]."""

_ABOVE = 6
"""Folders above the file in which a package is looked for."""

_DEEP = 3
"""Folders below an entry of ROS_PACKAGE_PATH in which a package is looked for."""

_INNER = ("urdf", "urdfs", "robot", "robots", "xacro", "description")
"""What the folder of the URDF is called where the robot's own is the one above."""


class Packages:
    """The folders of packages by name, seen from a robot's file in `folder`.

    Asked in this order: the ones `given`; the package that the file lies in; ROS_PACKAGE_PATH;
    AMENT_PREFIX_PATH; folders of that name above the file, and beside it or those.
    """

    def __init__(self, folder: Path, given: Mapping[str, Path], environ: Mapping[str, str]) -> None:
        self._given = given
        self._environ = environ
        self._above = [folder, *folder.parents][: _ABOVE + 1]
        self.found: dict[str, Path] = {}
        """Every package that was asked for and is there."""

    @functools.cached_property
    def root(self) -> Path:
        """The folder of the package that the file lies in; without one, of the robot's files."""
        package = next((place for place in self._above if (place / "package.xml").is_file()), None)
        if package is not None:
            return package
        here = self._above[0]
        return here.parent if here.name.lower() in _INNER and here.parent.name else here

    def find(self, name: str) -> Path | None:
        """The package's folder; None where it is not found."""
        if name not in self.found:
            place = next((place for place in self._places(name) if place.is_dir()), None)
            if place is None:
                return None
            self.found[name] = place
        return self.found[name]

    def _places(self, name: str) -> Iterator[Path]:
        if name in self._given:
            yield self._given[name]
        if not name or name in (".", "..") or "/" in name or "\\" in name:
            return
        yield from (place for place in self._above if _called(place) == name)
        yield from self._of_ros(name)
        for prefix in self._entries(_AMENT):
            yield prefix / "share" / name
        yield from (place for place in self._above if place.name == name)
        yield from (place / name for place in self._above)

    def _of_ros(self, name: str) -> Iterator[Path]:
        for variable in _OF_ROS:
            for entry in self._entries(variable):
                if entry.name == name or _called(entry) == name:
                    yield entry
                yield entry / name
                yield from (place for place in _below(entry, _DEEP) if _called(place) == name)

    def _entries(self, variable: str) -> list[Path]:
        return [Path(entry) for entry in self._environ.get(variable, "").split(os.pathsep) if entry]

    def near(self, rest: str) -> Iterator[Path]:
        """Where a file of a package may lie if the folders above the robot's file are that package."""
        yield from (place / rest for place in self._above if place.parent != place)


def _called(place: Path) -> str:
    """The name in a folder's package.xml, "" without one."""
    try:
        found = _NAME.search(regular_files.content(place / "package.xml", _LARGEST))
    except (OSError, regular_files.FileTooLarge):
        return ""
    return found.group(1).decode("utf-8", "replace") if found else ""


def _below(folder: Path, deep: int) -> Iterator[Path]:
    try:
        inner = sorted(one for one in folder.iterdir() if one.is_dir() and not one.name.startswith("."))
    except OSError:
        return
    for one in inner:
        yield one
        if deep > 1:
            yield from _below(one, deep - 1)
