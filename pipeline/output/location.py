"""Checks that a folder may be an output folder, unlike the home, the working or the cache folder."""

import errno
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.terminal import pasted

NAME_MAX = 255
"""Largest number of bytes of a name on all usual file systems."""

MAX_NAME = 200
"""Largest number of bytes of an output folder's name; the names of its siblings are longer."""

CACHE_FOLDERS = ("ac", "cas", "ledger", "locks", "tmp")
"""The names of the folders in the cache folder."""

ELSEWHERE = "choose another place with output=FOLDER"

_INVALID_PATH_ERRORS = (errno.ENOTDIR, errno.ENAMETOOLONG, errno.ELOOP, errno.EINVAL)


def absolute(folder: str | Path) -> Path:
    """Returns the absolute path of an output folder: `~` is the home folder; a link is replaced by its
    target.

    Raises ConfigError if no folder can be at that path.
    """
    try:
        place = Path(os.path.abspath(os.path.expanduser(folder)))  # noqa: PTH100, PTH111  (links stay)
        place = place.resolve() if place.is_symlink() else place
        _require_valid(place, str(folder))
    except (ValueError, RuntimeError) as error:
        raise ConfigError(f"{folder} cannot be a folder: {error}", "output", ELSEWHERE) from error
    except OSError as error:
        if error.errno not in _INVALID_PATH_ERRORS:
            raise
        msg = f"{folder} cannot be a folder: {error.strerror}"
        raise ConfigError(msg, "output", ELSEWHERE) from error
    return place


def _require_valid(place: Path, text: str) -> None:
    if not place.name:
        msg = f"{text} cannot be an output folder"
        raise ConfigError(msg, "output", "name a folder, such as output=outputs/arm")
    if os.path.expanduser(text).startswith("~"):  # noqa: PTH111
        msg = f"{text} names the home folder of an unknown user"
        raise ConfigError(msg, "output", ELSEWHERE)
    for name, limit in (*((part, NAME_MAX) for part in place.parent.parts), (place.name, MAX_NAME)):
        if len(os.fsencode(name)) > limit:
            msg = f"the name {name[:20]}... is too long: {len(os.fsencode(name))} bytes"
            raise ConfigError(msg, "output", f"name a folder with output=FOLDER, in at most {limit} bytes")
    for folder in (*reversed(place.parents), place):
        # lstat raises for an invalid path; a folder that does not exist yet is allowed.
        try:
            folder.lstat()
        except (FileNotFoundError, PermissionError):
            return
        if not folder.is_symlink() and not folder.is_dir():
            raise ConfigError(f"{folder} is a file", "output", ELSEWHERE)
    if place.is_mount():
        msg = f"{place} is a mount point and cannot be replaced"
        raise ConfigError(
            msg, "output", f"name a folder in it, such as {pasted.override('output', str(place / 'arm'))}"
        )


def require_free(place: Path, reserved_paths: Mapping[str, Path], cache: Path) -> None:
    """Raises ConfigError if `place` is or contains one of the `reserved_paths` (description → path), the
    home, the working folder or the cache, or is inside a folder of the cache."""
    real_path = Path(os.path.realpath(place))
    reserved_paths = {**reserved_paths, "the cache folder": cache}
    if any(Path(os.path.realpath(cache / name)) in (real_path, *real_path.parents) for name in CACHE_FOLDERS):
        msg = f"{place} is in the cache folder, which is cleaned up"
        raise ConfigError(msg, "output", f"{ELSEWHERE}, such as output=outputs/arm")
    for description, reserved_path in (*_standard_folders(), *reserved_paths.items()):
        real_reserved = Path(os.path.realpath(reserved_path))
        if real_path == real_reserved or real_path in real_reserved.parents:
            verb = "is" if real_path == real_reserved else "holds"
            msg = f"{place} {verb} {description}, and a build replaces its output folder"
            raise ConfigError(msg, "output", f"{ELSEWHERE}, such as output=outputs/arm")


def _standard_folders() -> Iterator[tuple[str, Path]]:
    home = os.path.expanduser("~")  # noqa: PTH111  (Path.home() raises where there is none)
    if os.path.isabs(home):  # noqa: PTH117
        yield "your home folder", Path(home)
    yield "the working folder", Path.cwd()
