"""Examines the cache, the working folder, the free space, and the display."""

import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from linkwright.pipeline.caching.disk_space import MIN_FREE_BYTES, reserved
from linkwright.pipeline.doctor.examination import ExaminationResult

LARGE_BUILD_BYTES = 2 * 10**9
"""Free space [bytes] that the build of a large robot may need."""


def examine(environ: Mapping[str, str], cache: Path) -> Iterator[ExaminationResult]:
    """Yields the rows about the places that builds write to, and about the display."""
    yield _folder("cache", cache, "set cache.dir= or LINKWRIGHT_CACHE to a folder that you can write to")
    yield _folder("outputs", Path("outputs").resolve(), "work in a folder that you can write to")
    yield _folder("temporary", Path(tempfile.gettempdir()), "set TMPDIR to a folder that you can write to")
    yield _display(environ)


def _folder(subject: str, folder: Path, hint: str) -> ExaminationResult:
    existing = next(candidate for candidate in (folder, *folder.parents) if candidate.exists())
    try:
        if not existing.is_dir():
            raise NotADirectoryError(f"{existing} is not a folder")
        with reserved(existing, MIN_FREE_BYTES):
            pass
        free_bytes = shutil.disk_usage(existing).free
    except OSError as error:
        return ExaminationResult(
            subject, "wrong", f"{folder} cannot be written to: {error.strerror or error}", hint
        )
    detail = f"{folder}, {free_bytes / 10**9:.1f} GB free"
    if free_bytes < LARGE_BUILD_BYTES:
        return ExaminationResult(subject, "note", detail, "linkwright cache gc frees space")
    return ExaminationResult(subject, "ok", detail)


def _display(environ: Mapping[str, str]) -> ExaminationResult:
    if has_display(environ, sys.platform):
        return ExaminationResult("display", "ok", "there is one, for linkwright view")
    hint = "needed for linkwright view only; report.html has the live robot"
    return ExaminationResult("display", "note", "DISPLAY and WAYLAND_DISPLAY are not set", hint)


def has_display(environ: Mapping[str, str], system: str) -> bool:
    """Tells whether a window can be opened: on Linux if an X or a Wayland server is named, elsewhere
    always."""
    return not system.startswith("linux") or bool(environ.get("DISPLAY") or environ.get("WAYLAND_DISPLAY"))
