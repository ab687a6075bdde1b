"""Gives a new output the mode and the owner of the old output."""

import os
import shutil
import stat
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path


def make(folder: Path, like: Path) -> None:
    """Creates a folder; if the folder `like` exists, only the owner can open the new folder until `copy`."""
    folder.mkdir(mode=0o700 if like.is_dir() else 0o777)


def copy(old: Path, new: Path) -> None:
    """Gives `new` the mode and the owner of `old`, if `old` exists; all entries of `new` get the owner, too.

    Only root may change the owner of files. Other users can keep the group if they are members of it;
    otherwise the group's permissions are dropped, since they would apply to a different group.
    """
    if not old.exists():
        return
    status = old.stat()
    for path in _entries(new):
        entry_status = path.lstat()
        if (entry_status.st_uid, entry_status.st_gid) != (status.st_uid, status.st_gid):
            _change_owner(path, status)
    # After the owner, whose change clears bits of the mode.
    shutil.copystat(old, new)
    if new.stat().st_gid != status.st_gid:
        new.chmod(stat.S_IMODE(status.st_mode) & ~(stat.S_IRWXG | stat.S_ISGID))
    os.utime(new)


def _entries(path: Path) -> Iterator[Path]:
    """Yields the path, and all entries below it if it is a folder."""
    yield path
    for top, folders, files in os.walk(path):
        yield from (Path(top, name) for name in (*folders, *files))


def _change_owner(path: Path, owner: os.stat_result) -> None:
    if not hasattr(os, "chown"):
        return
    try:
        os.chown(path, owner.st_uid, owner.st_gid, follow_symlinks=False)
    except OSError:
        with suppress(OSError):
            os.chown(path, -1, owner.st_gid, follow_symlinks=False)
