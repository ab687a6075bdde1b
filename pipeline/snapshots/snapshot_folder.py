"""Checks and renews the snapshots in their folder; finds and removes left-over snapshots."""

import functools
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from linkwright.pipeline.errors import ConfigError, OutputError, ValidationFailed, reason
from linkwright.pipeline.snapshots.compare import differences
from linkwright.pipeline.snapshots.snapshot import Snapshot, all_subjects, file_of, names_of, snapshot
from linkwright.pipeline.snapshots.subjects import FOLDER, RobotRepository, SnapshotSubject
from linkwright.pipeline.snapshots.text import HEAD, read_entries, subject_of

_UPDATE_COMMANDS = "linkwright snapshot, or pytest --linkwright-update"
"""The commands that make, renew and remove snapshots, for hints."""

ACCEPT_HINT = f"if the change is intended: {_UPDATE_COMMANDS}"
REWRITE_HINT = f"write it again: {_UPDATE_COMMANDS}"
MAKE_HINT = f"make it, and keep it in git: {_UPDATE_COMMANDS}"
REMOVE_HINT = f"remove it: {_UPDATE_COMMANDS}"

_LEFT_OVER_REASON = "its robot is gone or has another name"


@dataclass(frozen=True, slots=True)
class Renewal:
    """The result of writing a snapshot."""

    is_new: bool
    """Whether the snapshot did not exist before."""

    text: str
    """A message for the user: the path of the snapshot, and its changes."""


class SnapshotFolder:
    """The snapshots of a repository, and the `subjects` that should have them."""

    def __init__(self, repository: RobotRepository, environ: Mapping[str, str] = os.environ) -> None:
        """Lists the subjects; raises ConfigError if the repository has no robot."""
        self._repository = repository
        self._environ = environ
        self.subjects = all_subjects(repository, environ)

    def check(self, subject: SnapshotSubject) -> None:
        """Raises ValidationFailed if the snapshot of a subject is missing or different; raises
        LinkwrightError if the subject cannot be composed or built."""
        new_snapshot, old_text = self._new_snapshot_and_old_text(subject)
        where = f"{FOLDER}/{new_snapshot.file}"
        if old_text is None:
            raise ValidationFailed(f"there is no snapshot of {subject.title}", where, MAKE_HINT)
        if read_entries(old_text) is None:
            raise ValidationFailed(
                "it was written by another version, in another format", where, REWRITE_HINT
            )
        changes = differences(old_text, new_snapshot.text)
        if changes:
            error = ValidationFailed("the robot has changed", where)
            for line in (*changes, f"→ {ACCEPT_HINT}"):
                error.add_note(line)
            raise error

    def renew(self, subject: SnapshotSubject) -> Renewal | None:
        """Writes the snapshot of a subject, and returns the result; None if nothing has changed. Raises
        LinkwrightError as `check` does, and OutputError if the snapshot cannot be written."""
        new_snapshot, old_text = self._new_snapshot_and_old_text(subject)
        changes = [] if old_text is None else differences(old_text, new_snapshot.text)
        if old_text is not None and not changes:
            return None
        _write(self._repository.snapshots / new_snapshot.file, new_snapshot.text)
        text = "made" if old_text is None else "\n  ".join(changes)
        return Renewal(old_text is None, f"{FOLDER}/{new_snapshot.file}: {text}")

    def left_over_snapshots(self) -> list[str]:
        """Returns the paths of snapshots whose robots no longer exist, or have another name now."""
        paths = []
        for file in sorted(self._repository.snapshots.glob("*.txt")):
            # Text files that are not snapshots have no entries, and stay.
            entries = read_entries(_text(file) or "")
            subject = None if entries is None else subject_of(entries)
            if subject is None or self._is_of_broken_experiment(subject):
                continue
            if subject not in self.subjects or self._has_another_name(subject, file):
                paths.append(f"{FOLDER}/{file.name}")
        return paths

    def check_left_over_snapshots(self) -> None:
        """Raises ValidationFailed if snapshots are left over."""
        paths = self.left_over_snapshots()
        if paths:
            raise ValidationFailed(f"left over: {_LEFT_OVER_REASON}", ", ".join(paths), REMOVE_HINT)

    def remove_left_over_snapshots(self) -> list[str]:
        """Removes the left-over snapshots; returns a message about each of them."""
        paths = self.left_over_snapshots()
        for path in paths:
            (self._repository.folder / path).unlink(missing_ok=True)
        return [f"{path}: removed, {_LEFT_OVER_REASON}" for path in paths]

    def _new_snapshot_and_old_text(self, subject: SnapshotSubject) -> tuple[Snapshot, str | None]:
        """Returns a new snapshot of a subject, and the text of its file, which is None if there is no file
        yet."""
        new_snapshot = snapshot(self._repository, subject, self._environ)
        self._require_unique_name(new_snapshot.name)
        old_text = _text(self._repository.snapshots / new_snapshot.file)
        if old_text is not None and not old_text.startswith(HEAD):
            msg = "it is not a snapshot, and would be replaced"
            raise OutputError(msg, f"{FOLDER}/{new_snapshot.file}", "move the file")
        return new_snapshot, old_text

    def _require_unique_name(self, name: str) -> None:
        """Raises ConfigError if several subjects have robots of this name."""
        # Some file systems do not distinguish upper and lower case.
        namesakes = [
            subject for subject in self.subjects if self._names.get(subject, "").lower() == name.lower()
        ]
        if len(namesakes) > 1:
            msg = f"several robots have the name {name}, and would share a snapshot and an output folder"
            titles = "; ".join(subject.title for subject in namesakes)
            raise ConfigError(msg, titles, "give each robot its own name: name: ...")

    def _is_of_broken_experiment(self, subject: SnapshotSubject) -> bool:
        """Tells whether a subject has an experiment that cannot be composed, so that the robots that it
        belongs to are unknown."""
        experiment = SnapshotSubject(experiment=subject.experiment)
        return experiment in self.subjects and experiment not in self._names

    def _has_another_name(self, subject: SnapshotSubject, file: Path) -> bool:
        """Tells whether the robot of a subject has another name than its snapshot in `file`; False if the
        robot cannot be composed."""
        name = self._names.get(subject)
        return name is not None and file.name != file_of(name)

    @functools.cached_property
    def _names(self) -> dict[SnapshotSubject, str]:
        """The name of the robot of each subject that can be composed."""
        return names_of(self._repository, self.subjects, self._environ)


def _text(file: Path) -> str | None:
    """Returns the text of a file; None if it does not exist. Raises OutputError if it cannot be read."""
    try:
        return file.read_bytes().decode(errors="replace")
    except FileNotFoundError:
        return None
    except OSError as error:
        raise OutputError(f"it cannot be read: {reason(error)}", f"{FOLDER}/{file.name}") from None


def _write(file: Path, text: str) -> None:
    """Writes a snapshot, and its folder if there is none. Raises OutputError if that fails."""
    try:
        file.parent.mkdir(exist_ok=True)
        file.write_bytes(text.encode())
    except OSError as error:
        raise OutputError(f"it cannot be written: {reason(error)}", f"{FOLDER}/{file.name}") from None
