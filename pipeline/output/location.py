"""Checks that a folder may be an output folder: not the home, the working or the cache folder, say."""

import errno
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.terminal import pasted

NAME_MAX = 255
"""Most bytes of a name, on all usual file systems."""

LONGEST = 200
"""Most bytes of an output folder's name: the names beside it are longer."""

CACHED = ("ac", "cas", "ledger", "locks", "tmp")
"""The folders in the cache folder."""

ELSEWHERE = "choose another place with output=FOLDER"

_NO_PLACE = (errno.ENOTDIR, errno.ENAMETOOLONG, errno.ELOOP, errno.EINVAL)


def absolute(folder: str | Path) -> Path:
    """The absolute path of an output folder: `~` is the home folder; a link stands for its target.

    ConfigError where no folder can be at that path.
    """
    try:
        place = Path(os.path.abspath(os.path.expanduser(folder)))  # noqa: PTH100, PTH111  (links stay)
        place = place.resolve() if place.is_symlink() else place
        _check(place, str(folder))
    except (ValueError, RuntimeError) as error:
        raise ConfigError(f"{folder} cannot be a folder: {error}", "output", ELSEWHERE) from error
    except OSError as error:
        if error.errno not in _NO_PLACE:
            raise
        msg = f"{folder} cannot be a folder: {error.strerror}"
        raise ConfigError(msg, "output", ELSEWHERE) from error
    return place


def _check(place: Path, given: str) -> None:
    if not place.name:
        msg = f"{given} cannot be an output folder"
        raise ConfigError(msg, "output", "name a folder, such as output=outputs/arm")
    if os.path.expanduser(given).startswith("~"):  # noqa: PTH111
        msg = f"{given} names the home folder of an unknown user"
        raise ConfigError(msg, "output", ELSEWHERE)
    for name, most in (*((one, NAME_MAX) for one in place.parent.parts), (place.name, LONGEST)):
        if len(os.fsencode(name)) > most:
            msg = f"the name {name[:20]}... is too long: {len(os.fsencode(name))} bytes"
            raise ConfigError(msg, "output", f"name a folder with output=FOLDER, in at most {most} bytes")
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


def require_free(place: Path, taken: Mapping[str, Path], cache: Path) -> None:
    """ConfigError where `place` is or contains one of the `taken` paths (description → path), the home, the
    working folder or the cache, or is inside the folders of the cache."""
    real = Path(os.path.realpath(place))
    taken = {**taken, "the cache folder": cache}
    if any(Path(os.path.realpath(cache / name)) in (real, *real.parents) for name in CACHED):
        msg = f"{place} is in the cache folder, which is cleaned up"
        raise ConfigError(msg, "output", f"{ELSEWHERE}, such as output=outputs/arm")
    for what, other in (*_usual(), *taken.items()):
        there = Path(os.path.realpath(other))
        if real == there or real in there.parents:
            how = "is" if real == there else "holds"
            msg = f"{place} {how} {what}, and a build replaces its output folder"
            raise ConfigError(msg, "output", f"{ELSEWHERE}, such as output=outputs/arm")


def _usual() -> Iterator[tuple[str, Path]]:
    home = os.path.expanduser("~")  # noqa: PTH111  (Path.home() raises where there is none)
    if os.path.isabs(home):  # noqa: PTH117
        yield "your home folder", Path(home)
    yield "the working folder", Path.cwd()
