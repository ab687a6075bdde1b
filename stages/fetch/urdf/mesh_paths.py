"""Resolves the names of meshes in a URDF to files."""

from __future__ import annotations

import functools
import os
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from linkwright.stages.fetch.urdf.ros_packages import Packages
from linkwright.stages.robot.system import regular_files

_MOST_SEEN = 50_000
"""Files below the robot's folder that are looked through for one that is not where it should be."""

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+)://")
_DRIVE = re.compile(r"[A-Za-z]:[\\/]")


@dataclass(frozen=True, slots=True)
class MeshPlace:
    """The file that a mesh's name refers to; None for none.

    `searched`: it is not at the named path, but the only file of that name. `why`: the reason for None.
    """

    file: Path | None
    searched: bool = False
    why: str = ""


class MeshPlaces:
    """Finds the files that a robot's file in `folder` names.

    `meshdir`: MuJoCo's, from the URDF's extension; "" for none.
    """

    def __init__(self, folder: Path, packages: Packages, meshdir: str) -> None:
        self._folder = folder
        self._packages = packages
        self._meshdir = meshdir

    def find(self, name: str) -> MeshPlace:
        scheme = _SCHEME.match(name)
        if scheme and scheme.group(1).lower() not in ("package", "model", "file"):
            return MeshPlace(None, why=f"{scheme.group(1)}:// is not supported: meshes are not downloaded")
        for spelt in dict.fromkeys((name, unquote(name), name.replace("\\", "/"))):
            for candidate in self._meant(spelt):
                if regular_files.is_file(candidate):
                    return MeshPlace(candidate)
                if regular_files.is_special(candidate):
                    return MeshPlace(None, why=regular_files.NOT_REGULAR)
        return self._search(name)

    def _meant(self, name: str) -> Iterator[Path]:
        """The path that a name refers to."""
        rest = re.sub(r"^(?:package|model|file)://", "", name, flags=re.IGNORECASE)
        if name.lower().startswith(("package://", "model://")):
            package, _, inner = rest.partition("/")
            place = self._packages.find(package) if package else self._folder
            if place is not None:
                yield place / inner.lstrip("/")
        else:
            yield self._folder / rest
        if self._meshdir:
            # MuJoCo takes the folders off a name by default.
            yield self._folder / self._meshdir / PurePosixPath(rest).name
            yield self._folder / self._meshdir / rest.lstrip("/")

    def _search(self, name: str) -> MeshPlace:
        """Searches a missing file: below a folder above, else by its name."""
        steps = [step for step in re.sub(r"^\w+://", "", name).replace("\\", "/").split("/") if step]
        if not steps:
            return MeshPlace(None, why="it does not name a file")
        if ".." not in steps:
            inner = [steps, steps[1:]] if _SCHEME.match(name) else [steps]
            for rest in ("/".join(one) for one in inner if one):
                found = next(
                    (place for place in self._packages.near(rest) if regular_files.is_file(place)), None
                )
                if found is not None:
                    return MeshPlace(found, searched=True)
        alike = self._by_name.get(steps[-1].casefold(), [])
        if not alike:
            return MeshPlace(
                None, why="there is no such file, and no file of that name in the robot's folder"
            )
        shared = [_shared_tail(steps, path.parts) for path in alike]
        best = [path for path, score in zip(alike, shared, strict=True) if score == max(shared)]
        if len(best) > 1:
            named = ", ".join(sorted(_relative(path, self._packages.root) for path in best)[:3])
            return MeshPlace(None, why=f"there is no such file, and several files have that name: {named}")
        return MeshPlace(best[0], searched=True)

    @functools.cached_property
    def _by_name(self) -> Mapping[str, list[Path]]:
        """The files below the robot's folder by name, however it is spelt."""
        found: dict[str, list[Path]] = defaultdict(list)
        seen = 0
        for folder, inner, files in os.walk(self._packages.root):
            inner[:] = sorted(one for one in inner if not one.startswith("."))
            for file in sorted(files):
                found[file.casefold()].append(Path(folder, file))
            seen += len(files) + len(inner)
            if seen > _MOST_SEEN:
                break
        return found

    def roots(self) -> list[Path]:
        """The folders of the robot: its own, and those of the packages that it names."""
        return [self._packages.root, *self._packages.found.values()]

    def shown(self, file: Path) -> str:
        """A file as messages name it: without anything about this computer."""
        return self.public(file) or file.name

    def public(self, file: Path) -> str:
        """A file by a name that reveals nothing of this computer, "" where it has none."""
        file = Path(os.path.normpath(file))
        if file.is_relative_to(self._packages.root):
            return Path(os.path.relpath(file, self._folder)).as_posix()
        for name, place in sorted(self._packages.found.items()):
            if file.is_relative_to(place):
                return f"package://{name}/{file.relative_to(place).as_posix()}"
        return ""

    def is_private(self, name: str) -> bool:
        """Whether a name reveals where on this computer a file is."""
        return name.lower().startswith("file://") or name.startswith("/") or bool(_DRIVE.match(name))


def _relative(path: Path, root: Path) -> str:
    return path.relative_to(root).as_posix()


def _shared_tail(wanted: list[str], there: tuple[str, ...]) -> int:
    """How many of the last steps of two paths agree: one in the same case more than one that is not."""
    score = 0
    for one, other in zip(reversed(wanted), reversed(there), strict=False):
        if one.casefold() != other.casefold():
            break
        score += 2 if one == other else 1
    return score
