"""Checks and renews the snapshots in their folder; finds missing and left-over snapshots."""

import functools
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from linkwright.pipeline.errors import ConfigError, OutputError, ValidationFailed, reason
from linkwright.pipeline.snapshots.compare import differences
from linkwright.pipeline.snapshots.snapshot import Snapshot, all_subjects, file_of, names_of, snapshot
from linkwright.pipeline.snapshots.subjects import FOLDER, RobotRepository, SnapshotSubject
from linkwright.pipeline.snapshots.text import HEAD, read, subject_of

RENEW = "if that is meant: linkwright snapshot, or pytest --linkwright-update"
MAKE = "make it, and keep it in git: linkwright snapshot, or pytest --linkwright-update"
REMOVE = "remove it: linkwright snapshot, or pytest --linkwright-update"


@dataclass(frozen=True, slots=True)
class Renewal:
    """A snapshot that was written. `is_new`: whether it did not exist before; `text`: a text about its
    changes."""

    is_new: bool
    text: str


class SnapshotFolder:
    """The snapshots of a repository, and the `subjects` that should have them.

    Raises ConfigError if the repository has no robot.
    """

    def __init__(self, repository: RobotRepository, environ: Mapping[str, str] = os.environ) -> None:
        self._repository = repository
        self._environ = environ
        self.subjects = all_subjects(repository, environ)

    def check(self, subject: SnapshotSubject) -> None:
        """Raises ValidationFailed if the snapshot of a subject is missing or different; raises
        LinkwrightError if the subject cannot be composed or built."""
        current, kept_text = self._new_and_kept(subject)
        where = f"{FOLDER}/{current.file}"
        if kept_text is None:
            raise ValidationFailed(f"there is no snapshot of {subject.title}", where, MAKE)
        if read(kept_text) is None:
            raise ValidationFailed("it was written by another version, in another format", where, RENEW)
        changes = differences(kept_text, current.text)
        if changes:
            error = ValidationFailed("the robot has changed", where)
            for line in (*changes, f"→ {RENEW}"):
                error.add_note(line)
            raise error

    def renew(self, subject: SnapshotSubject) -> Renewal | None:
        """Writes the snapshot of a subject, and returns its renewal; None if nothing changed. Raises
        LinkwrightError as `check` does, and OutputError if the snapshot cannot be written."""
        current, kept_text = self._new_and_kept(subject)
        changes = [] if kept_text is None else differences(kept_text, current.text)
        if kept_text is not None and not changes:
            return None
        _write(self._repository.snapshots / current.file, current.text)
        text = "\n  ".join(changes) if changes else "made"
        return Renewal(kept_text is None, f"{FOLDER}/{current.file}: {text}")

    def left_over(self) -> list[str]:
        """Returns the paths of snapshots whose robots no longer exist, or have another name now."""
        paths = []
        for file in sorted(self._repository.snapshots.glob("*.txt")):
            entries = read(_content(file) or "")
            owner = None if entries is None else subject_of(entries)
            if owner is not None and (owner not in self.subjects or self._moved(owner, file)):
                paths.append(f"{FOLDER}/{file.name}")
        return paths

    def check_left_over(self) -> None:
        """Raises ValidationFailed if snapshots are left over."""
        paths = self.left_over()
        if paths:
            raise ValidationFailed(
                "left over: its robot is gone or has another name", ", ".join(paths), REMOVE
            )

    def remove_left_over(self) -> list[str]:
        """Removes the left-over snapshots; returns a message about each of them."""
        paths = self.left_over()
        for path in paths:
            (self._repository.folder / path).unlink(missing_ok=True)
        return [f"{path}: removed, its robot is gone or has another name" for path in paths]

    def _new_and_kept(self, subject: SnapshotSubject) -> tuple[Snapshot, str | None]:
        """Returns the new snapshot of a subject, and the text of the kept one; None if there is none yet."""
        current = snapshot(self._repository, subject, self._environ)
        rivals = [
            rival for rival in self.subjects if self._names.get(rival, "").lower() == current.name.lower()
        ]
        if len(rivals) > 1:
            msg = f"several have the name {current.name}, and would share a snapshot and an output folder"
            titles = "; ".join(rival.title for rival in rivals)
            raise ConfigError(msg, titles, "give each a name of its own: name: ...")
        kept_text = _content(self._repository.snapshots / current.file)
        if kept_text is not None and not kept_text.startswith(HEAD):
            msg = "it is not a snapshot, and would be replaced"
            raise OutputError(msg, f"{FOLDER}/{current.file}", "move the file")
        return current, kept_text

    def _moved(self, subject: SnapshotSubject, file: Path) -> bool:
        name = self._names.get(subject)
        return name is not None and file.name != file_of(name)

    @functools.cached_property
    def _names(self) -> dict[SnapshotSubject, str]:
        return names_of(self._repository, self.subjects, self._environ)


def _content(file: Path) -> str | None:
    """Returns the text of a file; None if it does not exist."""
    try:
        return file.read_bytes().decode(errors="replace")
    except FileNotFoundError:
        return None
    except OSError as error:
        raise OutputError(f"it cannot be read: {reason(error)}", f"{FOLDER}/{file.name}") from None


def _write(file: Path, text: str) -> None:
    try:
        file.parent.mkdir(exist_ok=True)
        file.write_bytes(text.encode())
    except OSError as error:
        raise OutputError(f"it cannot be written: {reason(error)}", f"{FOLDER}/{file.name}") from None
