"""Keeps paths within the folders of the configuration: files outside are never options.

Paths are normalised as text: a link in a folder may lead anywhere, since its owner set it, but `..` may not.
"""

import os
from collections.abc import Iterable
from pathlib import Path

from linkwright.stages.robot.errors import Diagnostic

_HINT = "put the file below a folder that --config-dir names, as DIR/robot/NAME.yaml or DIR/mesh/NAME.yaml"


class OutsideError(Exception):
    """A defaults list or an option names a `path` outside the folders of the configuration."""

    def __init__(self, path: str) -> None:
        super().__init__(path)
        self.path = path


def is_inside(path: str) -> bool:
    """Tells whether a path is relative and has no `..`, so that it stays in any folder."""
    return not _is_absolute(path) and ".." not in path.split("/")


def place(base: Path, path: str, folders: Iterable[Path]) -> Path | None:
    """Returns `path` from `base`, normalised; None if the result is in none of `folders`."""
    if is_inside(path):
        return base / path
    if _is_absolute(path):
        return None
    target = Path(os.path.normpath(base / path))
    return target if any(target.is_relative_to(folder) for folder in folders) else None


def _is_absolute(path: str) -> bool:
    """Tells whether a path begins at a root or has a scheme, on any operating system."""
    return path.startswith("/") or "//" in path or "\\" in path


def outside_problem(path: str, where: str) -> Diagnostic:
    """Returns the problem of a path that leaves the folders of the configuration."""
    return Diagnostic("E-OPTION", f"{path} is outside the folders of the configuration", where, _HINT)
