"""Writes the output folder beside its path, swaps it in by renames, and repairs it after a kill.

For `outputs/arm` the names beside it are `.arm.tmp` (a folder that is being written or removed),
`.arm.old` (the last build, complete, while the new folder is swapped in), `arm.replaced` (files that were
in the way) and the lock in `.linkwright/`. If the process is killed at any moment, the next run finds the
old or the new folder complete. Files that are not linkwright's move from the old folder to the new folder
after the swap, each by one rename.
"""

import contextlib
import errno
import itertools
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path, PurePosixPath

from linkwright.pipeline import lock
from linkwright.pipeline.caching import disk_space
from linkwright.pipeline.caching.store import write_tree
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import ConfigError, InTheWay, LinkwrightError, OutputError, reason
from linkwright.pipeline.output import access, conflicts, manifest
from linkwright.pipeline.output.location import absolute
from linkwright.pipeline.output.manifest import is_folder

FAILED = ".failed"
"""The suffix of the folder with the report of a failed build."""


class Output:
    """A build's output folder, and its siblings `<output>.failed` and `<output>.<until>`.

    Files in the way stop a build, or with `overwrite` move to `<folder>.replaced`. `report` is called
    with a line about files that are kept or moved, and while the build waits for another build of the
    same folder. Raises ConfigError if no folder can be at `target`.
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
        """Returns the output folder, or its sibling with a suffix."""
        return self.target.with_name(self.target.name + suffix)

    def judge(self, suffix: str = "", coming: Iterable[str] = ()) -> None:
        """Raises ConfigError if a build that writes the `coming` paths would replace files that are not
        linkwright's. Changes nothing."""
        folder = self.folder(suffix)
        with contextlib.ExitStack() as stack, output_errors(folder):
            place = lock.lock_path(self.target)
            if place.is_file():
                # During the swap of another build its files would look changed or missing.
                with contextlib.suppress(OSError):
                    stack.enter_context(lock.acquired(place, self._wait))
            self._judge(folder, coming)

    def prepare(self, suffix: str = "", coming: Iterable[str] = ()) -> None:
        """Repairs the folder after an interrupted run, checks it, and reports the files that will be kept.

        Raises ConfigError as `judge` does, and OutputError if the folder cannot be written.
        """
        folder = self.folder(suffix)
        with self._locked(), output_errors(folder):
            with contextlib.suppress(OSError):
                self._repair(self.folder(FAILED))
            self._repair(folder)
            kept_paths = self._judge(folder, coming)
            _staging(folder).mkdir()
            _staging(folder).rmdir()
        if kept_paths:
            self._report(f"kept, since not linkwright's: {conflicts.path_list(kept_paths)}")

    def size(self, suffix: str = "") -> int:
        """Returns the size [bytes] of the last build in the folder, 0 without a build."""
        folder = self.folder(suffix)
        with contextlib.suppress(OSError):
            files = [folder / path for path in manifest.written_files(folder) or {}]
            return sum(file.lstat().st_size for file in files if file.is_file())
        return 0

    @contextlib.contextmanager
    def room(self, size: int) -> Iterator[None]:
        """Reserves `size` bytes on the disk of the prepared output; raises OutputError if the space is
        missing."""
        with contextlib.ExitStack() as stack:
            with output_errors(self.target):
                stack.enter_context(disk_space.reserved(lock.beside(self.target).parent, size))
            yield

    def publish(
        self, files: Mapping[str, bytes], suffix: str = "", digests: Mapping[str, str] | None = None
    ) -> Path:
        """Replaces linkwright's files in the folder by `files`; returns the folder.

        `digests`: known SHA-256 digests. Raises InTheWay if other files than linkwright's are in the way.
        """
        folder = self.folder(suffix)
        with self._locked(), output_errors(folder):
            self._repair(folder)
            self._require_free(folder, files)
            try:
                # A new folder beside the output holds the same content: nobody else may read it.
                like = folder if folder.exists() else self.target
                _stage(_staging(folder), files, digests or {}, like)
                self._swap(folder)
            except BaseException:
                with contextlib.suppress(OSError):
                    self._repair(folder)
                raise
        return folder

    def remove(self, suffix: str) -> None:
        """Removes linkwright's files from a sibling, and the sibling if it is then empty.

        A file that cannot be removed is reported; it is not an error.
        """
        folder = self.folder(suffix)
        try:
            if not is_folder(folder) or manifest.written_files(folder) is None:
                return
            with self._locked(), output_errors(folder):
                self._repair(folder)
                self._remove_ours(folder)
        except (LinkwrightError, OSError) as error:
            self._report(f"{folder} was not removed: {error}")

    def _remove_ours(self, folder: Path) -> None:
        own_files = manifest.written_files(folder) or {}
        manifest.write_if_missing(folder, own_files)
        entries = manifest.foreign_or_changed(folder, own_files, (), self._reader)
        kept_paths = {entry.path for entry in entries}
        if "report.json" not in kept_paths:
            # First: without it, an incomplete folder after a kill does not count as a build.
            (folder / "report.json").unlink(missing_ok=True)
        parents = manifest.parents(own_files)
        manifest.clear_but_mark(folder, own_files.keys() - kept_paths, lambda path: path in parents)

    def _judge(self, folder: Path, coming: Iterable[str]) -> list[str]:
        """Returns the paths of files that will be kept; raises ConfigError if a file is in the way."""
        conflicts.require_folder(folder)
        if not folder.exists():
            return []
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        clashes = conflicts.find_conflicts(folder, coming, self._reader)
        if blockers := clashes.against(self._overwrite):
            raise ConfigError(
                conflicts.message(folder, blockers), "output", conflicts.conflict_hint(folder, clashes)
            )
        return conflicts.without_locks(clashes.kept_paths)

    def _require_free(self, folder: Path, files: Iterable[str]) -> None:
        """Raises InTheWay if the final list of `files` would replace files that are not linkwright's."""
        try:
            conflicts.require_folder(folder)
        except ConfigError as error:
            raise InTheWay(error.message, error.where, error.hint) from error
        clashes = conflicts.find_conflicts(folder, files, self._reader)
        if blockers := clashes.against(self._overwrite):
            raise InTheWay(
                conflicts.message(folder, blockers), str(folder), conflicts.conflict_hint(folder, clashes)
            )

    def _swap(self, folder: Path) -> None:
        """Renames the staged folder to the output folder. Folders are removed only under the staging name.

        So the folder `.old` is always complete and can be restored.
        """
        if folder.exists():
            manifest.write_if_missing(folder, manifest.written_files(folder) or {})
            folder.rename(_old_folder(folder))
        _staging(folder).rename(folder)
        self._retire(folder)

    def _retire(self, folder: Path) -> None:
        """Moves files that are not linkwright's from the old to the new folder, and removes the rest."""
        old = _old_folder(folder)
        if not old.exists():
            return
        clashes = conflicts.find_conflicts(old, manifest.written_files(folder) or {}, self._reader)
        new_paths = [move_aside(old / path, folder, path) for path in clashes.blockers]
        for path in clashes.kept_paths:
            if _can_take(folder, path):
                (old / path).rename(folder / path)
            else:
                new_paths.append(move_aside(old / path, folder, path))
        old.rename(_staging(folder))
        self._discard(folder)
        if new_paths:
            paths = conflicts.path_list(map(os.path.relpath, new_paths))
            self._report(f"was in the way, and was moved to {paths}")

    def _repair(self, folder: Path) -> None:
        """Completes or reverts an interrupted swap."""
        self._discard(folder)
        old = _old_folder(folder)
        if not os.path.lexists(old):
            return
        is_complete = is_folder(old) and manifest.written_files(old) is not None
        if is_complete and not os.path.lexists(folder):
            old.rename(folder)
        elif is_complete and manifest.written_files(folder) is not None:
            self._retire(folder)
        else:
            self._put_away(old, folder)

    def _discard(self, folder: Path) -> None:
        """Removes the staging folder; files in it that are not linkwright's are moved aside."""
        staged = _staging(folder)
        if is_folder(staged):
            own_files = manifest.written_files(staged)
            # Without a manifest the process was killed before it wrote any file.
            manifest.clear(staged, (own_files or {}).keys(), lambda _: own_files is not None)
        if os.path.lexists(staged):
            self._put_away(staged, folder)

    def _put_away(self, place: Path, folder: Path) -> None:
        new_path = move_aside(place, folder, place.name)
        self._report(f"{place.name} is not linkwright's, and was moved to {os.path.relpath(new_path)}")

    @contextlib.contextmanager
    def _locked(self) -> Iterator[None]:
        """Holds the lock of the folder and its siblings while the context lasts."""
        with contextlib.ExitStack() as stack:
            with output_errors(self.target):
                stack.enter_context(lock.acquired(lock.beside(self.target), self._wait))
            yield

    def _wait(self) -> None:
        self._report(f"waiting for another build of {self.target.name}")


def _stage(staging: Path, files: Mapping[str, bytes], digests: Mapping[str, str], like: Path) -> None:
    """Writes the files to a new folder, with the mode and the owner of `like` if `like` exists."""
    access.make(staging, like)
    manifest.write(staging, {path: digests.get(path) or sha256(data) for path, data in files.items()})
    write_tree(staging, files)
    access.copy(like, staging)


def _staging(folder: Path) -> Path:
    return folder.with_name(f".{folder.name}.tmp")


def _old_folder(folder: Path) -> Path:
    return folder.with_name(f".{folder.name}.old")


def _can_take(folder: Path, path: str) -> bool:
    """Tells whether `path` is free in the folder; creates its parent folders."""
    place = folder
    for name in PurePosixPath(path).parts[:-1]:
        place /= name
        if not os.path.lexists(place):
            place.mkdir()
        if not is_folder(place):
            return False
    return not os.path.lexists(folder / path)


def move_aside(place: Path, folder: Path, path: str) -> Path:
    """Moves `place` to `path` below `<folder>.replaced`, with a number if that path exists; returns the new
    path."""
    *above, last = PurePosixPath(path).parts
    target = _replaced_folder(folder)
    for name in above:
        places = _numbered(target / name)
        target = next(new for new in places if is_folder(new) or not os.path.lexists(new))
        target.mkdir(exist_ok=True)
    target = next(candidate for candidate in _numbered(target / last) if not os.path.lexists(candidate))
    place.rename(target)
    return target


def _replaced_folder(folder: Path) -> Path:
    """Returns the folder `<folder>.replaced`, created and marked as linkwright's; with a number if a foreign
    folder has that name."""
    default = folder.with_name(f"{folder.name}{conflicts.REPLACED}")
    target = next(
        candidate
        for candidate in _numbered(default)
        if not os.path.lexists(candidate) or (is_folder(candidate) and not manifest.is_foreign(candidate))
    )
    if not os.path.lexists(target):
        access.make(target, folder)
        access.copy(folder, target)
    manifest.write_if_missing(target, {})
    return target


def _numbered(path: Path) -> Iterator[Path]:
    yield path
    for number in itertools.count(2):
        yield path.with_name(f"{path.name}.{number}")


@contextlib.contextmanager
def output_errors(folder: Path) -> Iterator[None]:
    """Turns an OSError into an OutputError that names the folder."""
    try:
        yield
    except OSError as error:
        msg = f"the output folder cannot be written: {reason(error)}"
        action = "allow writing" if isinstance(error, PermissionError) else "free space"
        hint = f"choose another place with output=FOLDER, or {action} there"
        raise OutputError(msg, str(folder), hint) from error
