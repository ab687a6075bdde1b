"""Identifies the running program: its own code, and everything else that Python may import.

The identity is found without importing or reading any file; an unchanged build is recognised by it
(`pipeline.run.unchanged`).
"""

import hashlib
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

ROOMS = ("conf", "pipeline", "stages")
"""The folders of the program's own code."""

_PLUGINS = "hydra_plugins"
"""The namespace whose modules Hydra imports by itself."""


def identity() -> str:
    """Returns a digest of the interpreter, of the name, size and time of each file of the program, and of the
    names in each folder of Python's path: those of installed distributions hold their versions."""
    home = os.fspath(Path(__file__).resolve().parents[2])
    facts = [
        sys.version,
        sys.platform,
        sys.executable,
        home,
        [list(_files(f"{home}/{room}", f"{room}/")) for room in ROOMS],
        [[place, _names(place), _names(f"{place}/{_PLUGINS}")] for place in sys.path],
    ]
    return hashlib.sha256(json.dumps(facts).encode(errors="surrogatepass")).hexdigest()


def _files(folder: str, below: str) -> Iterator[tuple[str, int, int]]:
    """Yields path, size and time of change of each file, without those that Python compiles from them."""
    with os.scandir(folder) as entries:
        for entry in sorted(entries, key=lambda entry: entry.name):
            if entry.is_dir():
                if entry.name != "__pycache__":
                    yield from _files(entry.path, f"{below}{entry.name}/")
            else:
                status = entry.stat()
                yield f"{below}{entry.name}", status.st_size, status.st_mtime_ns


def _names(folder: str) -> list[str]:
    """Returns the names in a folder; for a file its size and time; [] if the path does not exist."""
    try:
        if os.path.isfile(folder):  # noqa: PTH113
            status = os.stat(folder)  # noqa: PTH116
            return [str(status.st_size), str(status.st_mtime_ns)]
        return sorted(os.listdir(folder))  # noqa: PTH208
    except OSError:
        return []
