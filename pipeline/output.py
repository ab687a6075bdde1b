"""The output folder: written beside its place, swapped in by renames, mended after a kill.

For `outputs/arm` the names beside it are `.arm.tmp` (being written, or being removed: never of
worth), `.arm.old` (the last build, whole, while the new one moves in) and `.arm.lock`. Whatever
moment the process is killed at, the next run finds the old or the new folder whole.
"""

import contextlib
import json
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath

from pipeline.errors import ConfigError, OutputError
from pipeline.lock import held

FORMAT = "linkwright-report"
"""The key by which `report.json` says that a folder is linkwright's."""

FAILED = ".failed"
"""The suffix of the folder that a failed build leaves its report in."""


class Output:
    """A build's output folder, and beside it `<output>.failed` and `<output>.<until>`."""

    def __init__(self, target: str | Path, tell: Callable[[str], None] = lambda _: None) -> None:
        """`tell` hears that another build of the same folder is waited for."""
        self._tell = tell
        self.target = Path(os.path.abspath(target))  # noqa: PTH100  (resolve() would follow a link's last part)
        if self.target.is_symlink():
            self.target = self.target.resolve()
        if not self.target.name:
            msg = f"{target} cannot be an output folder"
            raise ConfigError(msg, where="output", hint="name a folder, such as output=outputs/arm")

    def require_ours(self, suffix: str = "") -> None:
        """ConfigError where the place is taken by something that is not linkwright's."""
        with named(self.folder(suffix)):
            _refuse_foreign(self.folder(suffix))

    def prepare(self, suffix: str = "") -> None:
        """Mends what an interrupted run left, before anything is made.

        ConfigError where the place is taken by something that is not linkwright's; OutputError
        where it cannot be written.
        """
        folder = self.folder(suffix)
        with named(folder):
            _refuse_foreign(folder)
            with self._locked(folder):
                _mend(self.folder(FAILED))
                _mend(folder)
                _refuse_foreign(folder)
                # Whether it can be written is found out now rather than after the work.
                _staging(folder).mkdir()
                _staging(folder).rmdir()

    def publish(self, files: Mapping[str, bytes], suffix: str = "") -> Path:
        """Puts `files` in the place of the folder's whole content; the folder."""
        folder = self.folder(suffix)
        with self._locked(folder), named(folder):
            _mend(folder)
            _refuse_foreign(folder)
            try:
                write_tree(_staging(folder), files)
                _swap(folder)
            except BaseException:
                _mend(folder)
                raise
        return folder

    def remove(self, suffix: str) -> None:
        """Removes a sibling, if there is one and it is linkwright's."""
        folder = self.folder(suffix)
        if suffix and is_ours(folder):
            with self._locked(folder), named(folder):
                _mend(folder)
                folder.rename(_staging(folder))
                shutil.rmtree(_staging(folder))

    def folder(self, suffix: str = "") -> Path:
        return self.target.with_name(self.target.name + suffix)

    @contextlib.contextmanager
    def _locked(self, folder: Path) -> Iterator[None]:
        """One lock for the folder and its siblings."""
        file = self.target.with_name(f".{self.target.name}.lock")
        with contextlib.ExitStack() as stack:
            with named(folder):
                self.target.parent.mkdir(parents=True, exist_ok=True)
                stack.enter_context(held(file, self._wait))
            yield

    def _wait(self) -> None:
        self._tell(f"waiting for another build of {self.target.name}")


def is_ours(folder: Path) -> bool:
    """Whether linkwright wrote the folder: its `report.json` says so."""
    try:
        report = json.loads((folder / "report.json").read_bytes())
    except (OSError, ValueError):
        return False
    return isinstance(report, dict) and FORMAT in report


def write_tree(folder: Path, files: Mapping[str, bytes]) -> None:
    """Writes files by relative path into a folder, which is made if need be."""
    folder.mkdir(parents=True, exist_ok=True)
    made = {folder}
    for name in sorted(files):
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts:
            msg = f"{name!r} is no path inside a build"
            raise OutputError(msg, where=str(folder), hint="clear the cache folder and build again")
        target = folder / path
        if target.parent not in made:
            target.parent.mkdir(parents=True, exist_ok=True)
            made.add(target.parent)
        target.write_bytes(files[name])


def _staging(folder: Path) -> Path:
    return folder.with_name(f".{folder.name}.tmp")


def _old(folder: Path) -> Path:
    return folder.with_name(f".{folder.name}.old")


def _swap(folder: Path) -> None:
    """Moves the staged folder in. A folder is only ever removed under the staging name.

    So what lies under `.old` is always whole and can be put back.
    """
    if folder.exists():
        folder.rename(_old(folder))
    _staging(folder).rename(folder)
    _retire(folder)


def _retire(folder: Path) -> None:
    if _old(folder).exists():
        _old(folder).rename(_staging(folder))
        shutil.rmtree(_staging(folder))


def _mend(folder: Path) -> None:
    """Finishes or undoes a swap that was cut short."""
    if _staging(folder).exists():
        shutil.rmtree(_staging(folder))
    if not _old(folder).exists():
        return
    if folder.exists():
        _retire(folder)
    else:
        _old(folder).rename(folder)


def _refuse_foreign(folder: Path) -> None:
    """ConfigError where replacing `folder` would delete what linkwright did not make."""
    if not folder.exists() or is_ours(folder):
        return
    if not folder.is_dir():
        msg = f"{folder} is a file"
        raise ConfigError(msg, where="output", hint="choose another place with output=FOLDER")
    if not any(folder.iterdir()):
        return
    msg = f"{folder} holds files that linkwright did not make; a build would replace them"
    raise ConfigError(
        msg, where="output", hint="choose another place with output=FOLDER, or empty that folder"
    )


@contextlib.contextmanager
def named(folder: Path) -> Iterator[None]:
    """An OSError becomes an OutputError that names the folder."""
    try:
        yield
    except OSError as error:
        msg = f"the output folder cannot be written: {error.strerror or error}"
        hint = "choose another place with output=FOLDER, or make room there"
        raise OutputError(msg, where=str(folder), hint=hint) from error
