"""Who may use an output: its mode and its owner, which what replaces it keeps."""

import os
import shutil
import stat
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path


def make(folder: Path, like: Path) -> None:
    """Creates a folder; where the folder `like` exists, nobody else can open it until `copy`."""
    folder.mkdir(mode=0o700 if like.is_dir() else 0o777)


def copy(old: Path, new: Path) -> None:
    """Gives `new` the mode of `old`, if that exists, and the owner; all that is in `new` gets the owner, too.

    Only root may give files away. For others the group stays where they are members of it; where they are
    not, the group's permissions are dropped, since they would be another group's.
    """
    if not old.exists():
        return
    before = old.stat()
    for path in _all_of(new):
        there = path.lstat()
        if (there.st_uid, there.st_gid) != (before.st_uid, before.st_gid):
            _give(path, before)
    # After the owner, whose change clears bits of the mode.
    shutil.copystat(old, new)
    if new.stat().st_gid != before.st_gid:
        new.chmod(stat.S_IMODE(before.st_mode) & ~(stat.S_IRWXG | stat.S_ISGID))
    os.utime(new)


def _all_of(path: Path) -> Iterator[Path]:
    """The path, and all entries below it if it is a folder."""
    yield path
    for top, below, files in os.walk(path):
        yield from (Path(top, name) for name in (*below, *files))


def _give(path: Path, owner: os.stat_result) -> None:
    if not hasattr(os, "chown"):
        return
    try:
        os.chown(path, owner.st_uid, owner.st_gid, follow_symlinks=False)
    except OSError:
        with suppress(OSError):
            os.chown(path, -1, owner.st_gid, follow_symlinks=False)
