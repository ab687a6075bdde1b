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

_MAX_SEARCHED = 50_000
"""Largest number of files below the robot's folder that are searched for a misplaced file."""

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+)://")
_DRIVE = re.compile(r"[A-Za-z]:[\\/]")


@dataclass(frozen=True, slots=True)
class MeshPlace:
    """The place of a file that a URDF names."""

    file: Path | None
    searched: bool = False
    """Whether the file was found by a search, since none is at the named path."""

    why: str = ""
    """The reason why there is no file, or ""."""


class MeshPlaces:
    """Finds the files that a robot's file in `folder` names.

    `meshdir`: the folder of meshes in MuJoCo's extension of the URDF, or "".
    """

    def __init__(self, folder: Path, packages: Packages, meshdir: str) -> None:
        self._folder = folder
        self._packages = packages
        self._meshdir = meshdir

    def find(self, name: str) -> MeshPlace:
        """Returns the place of the file that a name refers to."""
        scheme = _SCHEME.match(name)
        if scheme and scheme.group(1).lower() not in ("package", "model", "file"):
            return MeshPlace(None, why=f"{scheme.group(1)}:// is not supported: meshes are not downloaded")
        for spelling in dict.fromkeys((name, unquote(name), name.replace("\\", "/"))):
            for candidate in self._possible_paths(spelling):
                if regular_files.is_file(candidate):
                    return MeshPlace(candidate)
                if regular_files.is_special(candidate):
                    return MeshPlace(None, why=regular_files.NOT_REGULAR)
        return self._search_elsewhere(name)

    def _possible_paths(self, name: str) -> Iterator[Path]:
        """Yields the paths that a name may refer to."""
        path_text = re.sub(r"^(?:package|model|file)://", "", name, flags=re.IGNORECASE)
        if name.lower().startswith(("package://", "model://")):
            package, _, inner = path_text.partition("/")
            place = self._packages.find(package) if package else self._folder
            if place is not None:
                yield place / inner.lstrip("/")
        else:
            yield self._folder / path_text
        if self._meshdir:
            # MuJoCo takes the folders off a name by default.
            yield self._folder / self._meshdir / PurePosixPath(path_text).name
            yield self._folder / self._meshdir / path_text.lstrip("/")

    def _search_elsewhere(self, name: str) -> MeshPlace:
        """Searches a missing file: below a folder above, or else by its name."""
        steps = [step for step in re.sub(r"^\w+://", "", name).replace("\\", "/").split("/") if step]
        if not steps:
            return MeshPlace(None, why="it does not name a file")
        if ".." not in steps:
            tails = [steps, steps[1:]] if _SCHEME.match(name) else [steps]
            for path_text in ("/".join(tail) for tail in tails if tail):
                file = next(
                    (
                        place
                        for place in self._packages.paths_above(path_text)
                        if regular_files.is_file(place)
                    ),
                    None,
                )
                if file is not None:
                    return MeshPlace(file, searched=True)
        same_name = self._by_name.get(steps[-1].casefold(), [])
        if not same_name:
            return MeshPlace(
                None, why="there is no such file, and no file of that name in the robot's folder"
            )
        scores = [_shared_tail(steps, path.parts) for path in same_name]
        best = [path for path, score in zip(same_name, scores, strict=True) if score == max(scores)]
        if len(best) > 1:
            names = ", ".join(sorted(_relative(path, self._packages.root) for path in best)[:3])
            return MeshPlace(None, why=f"there is no such file, and several files have that name: {names}")
        return MeshPlace(best[0], searched=True)

    @functools.cached_property
    def _by_name(self) -> Mapping[str, list[Path]]:
        """Returns the files below the robot's folder by name, without regard to upper and lower case."""
        paths: dict[str, list[Path]] = defaultdict(list)
        count = 0
        for folder, inner, files in os.walk(self._packages.root):
            inner[:] = sorted(folder_name for folder_name in inner if not folder_name.startswith("."))
            for file in sorted(files):
                paths[file.casefold()].append(Path(folder, file))
            count += len(files) + len(inner)
            if count > _MAX_SEARCHED:
                break
        return paths

    def roots(self) -> list[Path]:
        """Returns the folders of the robot: its own, and those of the packages that it names."""
        return [self._packages.root, *self._packages.found.values()]

    def name_in_messages(self, file: Path) -> str:
        """Returns the name of a file in messages, which reveals nothing of this computer."""
        return self.public_name(file) or file.name

    def public_name(self, file: Path) -> str:
        """Returns a name of a file that reveals nothing of this computer, or "" if it has none."""
        file = Path(os.path.normpath(file))
        if file.is_relative_to(self._packages.root):
            return Path(os.path.relpath(file, self._folder)).as_posix()
        for name, place in sorted(self._packages.found.items()):
            if file.is_relative_to(place):
                return f"package://{name}/{file.relative_to(place).as_posix()}"
        return ""

    def is_private(self, name: str) -> bool:
        """Tells whether a name reveals where on this computer a file is."""
        return name.lower().startswith("file://") or name.startswith("/") or bool(_DRIVE.match(name))


def _relative(path: Path, root: Path) -> str:
    return path.relative_to(root).as_posix()


def _shared_tail(named_steps: list[str], file_steps: tuple[str, ...]) -> int:
    """Returns how well the last steps of two paths agree; a step in the same case counts twice."""
    score = 0
    for step, other_step in zip(reversed(named_steps), reversed(file_steps), strict=False):
        if step.casefold() != other_step.casefold():
            break
        score += 2 if step == other_step else 1
    return score
