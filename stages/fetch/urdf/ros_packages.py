"""Finds the folders of ROS packages."""

from __future__ import annotations

import functools
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from linkwright.stages.robot.system import regular_files

_NAME = re.compile(rb"<name>\s*([^<\s]+)\s*</name>")
_ROS_VARIABLES = ("ROS_PACKAGE_PATH", "GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH")
_AMENT = "AMENT_PREFIX_PATH"
VARIABLES = (*_ROS_VARIABLES, _AMENT)
"""ROS's environment variables with the search paths of packages."""

_LARGEST = 1 << 20
"""Largest size of a package.xml [bytes]."""

_MAX_FOLDERS_ABOVE = 6
"""Number of folders above the file in which a package is searched."""

_MAX_DEPTH = 3
"""Depth below an entry of ROS_PACKAGE_PATH down to which a package is searched."""

_URDF_FOLDERS = ("urdf", "urdfs", "robot", "robots", "xacro", "description")
"""Names of the folder of a URDF whose parent is the robot's own folder."""


class Packages:
    """Finder of the folders of packages by name, as seen from a robot's file in `folder`.

    The places are searched in this order: `configured`; the package of the file itself; ROS_PACKAGE_PATH;
    AMENT_PREFIX_PATH; folders of that name among the folders above the file; and folders of that name next to
    the file or next to the folders above it.
    """

    def __init__(self, folder: Path, configured: Mapping[str, Path], environ: Mapping[str, str]) -> None:
        self._configured = configured
        self._environ = environ
        self._above = [folder, *folder.parents][: _MAX_FOLDERS_ABOVE + 1]
        self.found: dict[str, Path] = {}
        """Every requested package that exists."""

    @functools.cached_property
    def root(self) -> Path:
        """Returns the folder of the package of the file; without a package, the folder of the robot's
        files."""
        package = next((place for place in self._above if (place / "package.xml").is_file()), None)
        if package is not None:
            return package
        folder = self._above[0]
        return folder.parent if folder.name.lower() in _URDF_FOLDERS and folder.parent.name else folder

    def find(self, name: str) -> Path | None:
        """Returns the package's folder; None if it is not found."""
        if name not in self.found:
            # Unlike `Path.is_dir`, `isdir` raises nothing for a name that is too long.
            place = next((place for place in self._places(name) if os.path.isdir(place)), None)  # noqa: PTH112
            if place is None:
                return None
            self.found[name] = place
        return self.found[name]

    def _places(self, name: str) -> Iterator[Path]:
        if name in self._configured:
            yield self._configured[name]
        if not name or name in (".", "..") or "/" in name or "\\" in name:
            return
        yield from (place for place in self._above if _package_name(place) == name)
        yield from self._ros_places(name)
        for prefix in self._entries(_AMENT):
            yield prefix / "share" / name
        yield from (place for place in self._above if place.name == name)
        yield from (place / name for place in self._above)

    def _ros_places(self, name: str) -> Iterator[Path]:
        for variable in _ROS_VARIABLES:
            for entry in self._entries(variable):
                if entry.name == name or _package_name(entry) == name:
                    yield entry
                yield entry / name
                yield from (
                    place for place in _folders_below(entry, _MAX_DEPTH) if _package_name(place) == name
                )

    def _entries(self, variable: str) -> list[Path]:
        return [Path(entry) for entry in self._environ.get(variable, "").split(os.pathsep) if entry]

    def paths_above(self, inner_path: str) -> Iterator[Path]:
        """Yields the possible paths of a package's file if the folders above the robot's file are that
        package."""
        yield from (place / inner_path for place in self._above if place.parent != place)


def _package_name(place: Path) -> str:
    """Returns the name in a folder's package.xml, or ""."""
    try:
        match = _NAME.search(regular_files.content(place / "package.xml", _LARGEST))
    except (OSError, regular_files.FileTooLarge):
        return ""
    return match.group(1).decode("utf-8", "replace") if match else ""


def _folders_below(folder: Path, depth: int) -> Iterator[Path]:
    try:
        inner = sorted(
            entry for entry in folder.iterdir() if entry.is_dir() and not entry.name.startswith(".")
        )
    except OSError:
        return
    for subfolder in inner:
        yield subfolder
        if depth > 1:
            yield from _folders_below(subfolder, depth - 1)
