"""The output folder: written beside its place, swapped in by renames, repaired after a kill.

For `outputs/arm` the names beside it are `.arm.tmp` (being written, or being removed: never of
worth), `.arm.old` (the last build, whole, while the new one moves in), `arm.replaced` (what was in the
way) and the lock in `.linkwright/`. Whatever moment the process is killed at, the next run finds the old
or the new folder whole, and what is not linkwright's in it: it moves from the old folder to the new one,
each piece by one rename, once the new one is in its place.
"""

import contextlib
import errno
import itertools
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path, PurePosixPath

from pipeline import disk_space, lock
from pipeline.caching.store import write_tree
from pipeline.digest import sha256
from pipeline.errors import ConfigError, InTheWay, LinkwrightError, OutputError, reason
from pipeline.output import conflicts, manifest
from pipeline.output.location import absolute
from pipeline.output.manifest import is_folder

FAILED = ".failed"
"""The suffix of the folder that a failed build leaves its report in."""


class Output:
    """A build's output folder, and beside it `<output>.failed` and `<output>.<until>`.

    What is in the way of a build stops it, or with `overwrite` moves to `<folder>.replaced`. `report`
    hears what is carried over or moved, and that another build of the same folder is waited for.
    ConfigError where no folder can be at `target`.
    """

    def __init__(
        self,
        target: str | Path,
        report: Callable[[str], None] = lambda _: None,
        *,
        overwrite: bool = False,
    ) -> None:
        self.target = absolute(target)
        self._report = report
        self._overwrite = overwrite
        self._reader = manifest.DigestReader()

    def folder(self, suffix: str = "") -> Path:
        return self.target.with_name(self.target.name + suffix)

    def judge(self, suffix: str = "", coming: Iterable[str] = ()) -> None:
        """ConfigError where a build that writes the `coming` paths, and others, would have to replace
        what is not linkwright's. Changes nothing."""
        folder = self.folder(suffix)
        with contextlib.ExitStack() as stack, named(folder):
            place = lock.place(self.target)
            if place.is_file():
                # Another build may be moving its folder in: half-way, its files look changed or gone.
                with contextlib.suppress(OSError):
                    stack.enter_context(lock.held(place, self._wait))
            self._judge(folder, coming)

    def prepare(self, suffix: str = "", coming: Iterable[str] = ()) -> None:
        """Repairs what an interrupted run left, checks the folder, and reports what will be carried over.

        ConfigError as `judge`; OutputError where the folder cannot be written, which is found out now
        rather than after the work.
        """
        folder = self.folder(suffix)
        with self._locked(), named(folder):
            with contextlib.suppress(OSError):
                self._mend(self.folder(FAILED))
            self._mend(folder)
            kept = self._judge(folder, coming)
            _staging(folder).mkdir()
            _staging(folder).rmdir()
        if kept:
            self._report(f"kept, since not linkwright's: {conflicts.listed(kept)}")

    def size(self, suffix: str = "") -> int:
        """Bytes of the last build there, 0 where there is none."""
        folder = self.folder(suffix)
        with contextlib.suppress(OSError):
            files = [folder / path for path in manifest.ours(folder) or {}]
            return sum(file.lstat().st_size for file in files if file.is_file())
        return 0

    @contextlib.contextmanager
    def room(self, size: int) -> Iterator[None]:
        """Inside, so many bytes are taken where the output goes, which must be prepared; OutputError
        where there are not as many."""
        with contextlib.ExitStack() as stack:
            with named(self.target):
                stack.enter_context(disk_space.taken(lock.beside(self.target).parent, size))
            yield

    def publish(
        self, files: Mapping[str, bytes], suffix: str = "", digests: Mapping[str, str] | None = None
    ) -> Path:
        """Puts `files` in the place of all that linkwright wrote there before; the folder.

        `digests`: the SHA-256 of those of which it is known. InTheWay where that would replace what is
        not linkwright's.
        """
        folder = self.folder(suffix)
        with self._locked(), named(folder):
            self._mend(folder)
            self._require_free(folder, files)
            try:
                _stage(_staging(folder), files, digests or {})
                self._swap(folder)
            except BaseException:
                with contextlib.suppress(OSError):
                    self._mend(folder)
                raise
        return folder

    def remove(self, suffix: str) -> None:
        """Removes what linkwright wrote into a sibling, and the sibling if nothing else is in it.

        What cannot be removed is reported, and is no error.
        """
        folder = self.folder(suffix)
        try:
            if not is_folder(folder) or manifest.ours(folder) is None:
                return
            with self._locked(), named(folder):
                self._mend(folder)
                self._remove_ours(folder)
        except (LinkwrightError, OSError) as error:
            self._report(f"{folder} was not removed: {error}")

    def _remove_ours(self, folder: Path) -> None:
        own = manifest.ours(folder) or {}
        manifest.keep(folder, own)
        kept = {entry.path for entry in manifest.others(folder, own, (), self._reader)}
        if "report.json" not in kept:
            # First of all: without it, what a kill leaves is not taken for a build.
            (folder / "report.json").unlink(missing_ok=True)
        within = manifest.parents(own)
        manifest.clear(folder, own.keys() - kept, lambda path: path in within)

    def _judge(self, folder: Path, coming: Iterable[str]) -> list[str]:
        """The paths that will be carried over; ConfigError where something is in the way."""
        conflicts.require_folder(folder)
        if not folder.exists():
            return []
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        found = conflicts.look(folder, coming, self._reader)
        if stopped := found.against(self._overwrite):
            raise ConfigError(conflicts.message(folder, stopped), "output", conflicts.ways_out(folder, found))
        return conflicts.visible(found.carried)

    def _require_free(self, folder: Path, files: Iterable[str]) -> None:
        """InTheWay where the files, all of them known now, would replace what is not linkwright's."""
        try:
            conflicts.require_folder(folder)
        except ConfigError as error:
            raise InTheWay(error.message, error.where, error.hint) from error
        found = conflicts.look(folder, files, self._reader)
        if stopped := found.against(self._overwrite):
            raise InTheWay(conflicts.message(folder, stopped), str(folder), conflicts.ways_out(folder, found))

    def _swap(self, folder: Path) -> None:
        """Moves the staged folder in. A folder is only ever removed under the staging name.

        So what lies under `.old` is always whole and can be put back.
        """
        if folder.exists():
            manifest.keep(folder, manifest.ours(folder) or {})
            folder.rename(_old(folder))
        _staging(folder).rename(folder)
        self._retire(folder)

    def _retire(self, folder: Path) -> None:
        """Moves what is not linkwright's from the old folder to the new one, and removes the rest."""
        old = _old(folder)
        if not old.exists():
            return
        found = conflicts.look(old, manifest.ours(folder) or {}, self._reader)
        moved = [move_aside(old / path, folder, path) for path in found.stopped]
        for path in found.carried:
            if _can_take(folder, path):
                (old / path).rename(folder / path)
            else:
                moved.append(move_aside(old / path, folder, path))
        old.rename(_staging(folder))
        self._discard(folder)
        if moved:
            self._report(f"was in the way, and was moved to {conflicts.listed(map(os.path.relpath, moved))}")

    def _mend(self, folder: Path) -> None:
        """Finishes or undoes a swap that was cut short."""
        self._discard(folder)
        old = _old(folder)
        if not os.path.lexists(old):
            return
        whole = is_folder(old) and manifest.ours(old) is not None
        if whole and not os.path.lexists(folder):
            old.rename(folder)
        elif whole and manifest.ours(folder) is not None:
            self._retire(folder)
        else:
            self._put_away(old, folder)

    def _discard(self, folder: Path) -> None:
        """Removes what is staged; what no build of ours has put there is moved aside."""
        staged = _staging(folder)
        if is_folder(staged):
            own = manifest.ours(staged)
            # A kill may have come before the manifest: then there is nothing yet.
            manifest.clear(staged, (own or {}).keys(), lambda _: own is not None)
        if os.path.lexists(staged):
            self._put_away(staged, folder)

    def _put_away(self, place: Path, folder: Path) -> None:
        moved = move_aside(place, folder, place.name)
        self._report(f"{place.name} is not linkwright's, and was moved to {os.path.relpath(moved)}")

    @contextlib.contextmanager
    def _locked(self) -> Iterator[None]:
        """One lock for the folder and its siblings."""
        with contextlib.ExitStack() as stack:
            with named(self.target):
                stack.enter_context(lock.held(lock.beside(self.target), self._wait))
            yield

    def _wait(self) -> None:
        self._report(f"waiting for another build of {self.target.name}")


def _stage(staging: Path, files: Mapping[str, bytes], digests: Mapping[str, str]) -> None:
    staging.mkdir()
    manifest.write(staging, {path: digests.get(path) or sha256(data) for path, data in files.items()})
    write_tree(staging, files)


def _staging(folder: Path) -> Path:
    return folder.with_name(f".{folder.name}.tmp")


def _old(folder: Path) -> Path:
    return folder.with_name(f".{folder.name}.old")


def _can_take(folder: Path, path: str) -> bool:
    """Whether the folder has room for something at that path; makes the folders that it needs there."""
    place = folder
    for name in PurePosixPath(path).parts[:-1]:
        place /= name
        if not os.path.lexists(place):
            place.mkdir()
        if not is_folder(place):
            return False
    return not os.path.lexists(folder / path)


def move_aside(place: Path, folder: Path, path: str) -> Path:
    """Moves what is at `place` to `path` below `<folder>.replaced`, numbered where that is taken; where
    it is now."""
    to = folder.parent
    *above, last = (f"{folder.name}{conflicts.REPLACED}", *PurePosixPath(path).parts)
    for name in above:
        to = next(one for one in _numbered(to / name) if is_folder(one) or not os.path.lexists(one))
        to.mkdir(exist_ok=True)
    to = next(one for one in _numbered(to / last) if not os.path.lexists(one))
    place.rename(to)
    return to


def _numbered(path: Path) -> Iterator[Path]:
    yield path
    for number in itertools.count(2):
        yield path.with_name(f"{path.name}.{number}")


@contextlib.contextmanager
def named(folder: Path) -> Iterator[None]:
    """An OSError becomes an OutputError that names the folder."""
    try:
        yield
    except OSError as error:
        msg = f"the output folder cannot be written: {reason(error)}"
        hint = "choose another place with output=FOLDER, or make room there"
        raise OutputError(msg, where=str(folder), hint=hint) from error
