"""The folders of the configuration: files outside are no options, whatever a path says.

Paths are normalised as text: a link in a folder leads where its owner wants, and `..` behind it does not.
"""

import os
from collections.abc import Iterable
from pathlib import Path

from linkwright.stages.robot.errors import Diagnostic

HINT = "put the file below a folder that --config-dir names, as DIR/robot/NAME.yaml or DIR/mesh/NAME.yaml"


class OutsideError(Exception):
    """A defaults list, or an option, that leaves the folders of the configuration; `path`: what it names."""

    def __init__(self, path: str) -> None:
        super().__init__(path)
        self.path = path


def is_plain(path: str) -> bool:
    """Whether a path stays in its folder, whatever that is."""
    return not _is_absolute(path) and ".." not in path.split("/")


def place(base: Path, path: str, folders: Iterable[Path]) -> Path | None:
    """The place that `path` has from `base`, normalised; None where it is in none of `folders`."""
    if is_plain(path):
        return base / path
    if _is_absolute(path):
        return None
    found = Path(os.path.normpath(base / path))
    return found if any(found.is_relative_to(folder) for folder in folders) else None


def _is_absolute(path: str) -> bool:
    """Whether a path begins at a root, has a scheme, or may do so for some system."""
    return path.startswith("/") or "//" in path or "\\" in path


def outside(path: str, where: str) -> Diagnostic:
    """The problem of a path that leaves the folders of the configuration."""
    return Diagnostic("E-OPTION", f"{path} is outside the folders of the configuration", where, HINT)
