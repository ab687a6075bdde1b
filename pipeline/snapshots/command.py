"""Runs the command `linkwright snapshot`: writes or checks all snapshots, and prints a line about each."""

import sys
from collections.abc import Iterable
from pathlib import Path

from linkwright.pipeline.errors import ConfigError, LinkwrightError, ValidationFailed, exit_status, render
from linkwright.pipeline.snapshots.snapshot_folder import SnapshotFolder
from linkwright.pipeline.snapshots.subjects import FOLDER, RobotRepository, SnapshotSubject
from linkwright.pipeline.terminal.output import say
from linkwright.stages.robot.text.plural import count


def run(folder: Path, config_dirs: Iterable[str], check: bool) -> int:
    """Writes the snapshots of the repository in a folder, or only checks them; returns the exit status.

    An error of a subject is printed, and the other subjects are still written or checked. Raises ConfigError
    if there is no robot.
    """
    snapshots = SnapshotFolder(RobotRepository(folder, tuple(config_dirs)))
    errors: list[LinkwrightError] = []
    shown: set[str] = set()
    new = changed = 0
    for subject in snapshots.subjects:
        try:
            if check:
                snapshots.check(subject)
            elif renewal := snapshots.renew(subject):
                new += renewal.is_new
                changed += not renewal.is_new
                say(renewal.text)
        except LinkwrightError as error:
            errors.append(error)
            if (text := error_text(error, subject)) not in shown:  # robots of one name have one message
                shown.add(text)
                say(text, sys.stderr)
    if check:
        try:
            snapshots.check_left_over_snapshots()
        except ValidationFailed as error:
            errors.append(error)
            say(render(error), sys.stderr)
    else:
        removed = snapshots.remove_left_over_snapshots()
        changed += len(removed)
        for text in removed:
            say(text)
    counts = {"made": new, "changed": changed, "wrong": len(errors)}
    words = [f"{number} {word}" for word, number in counts.items() if number]
    if not (check or new or changed):
        words.insert(0, "none changed")
    say(", ".join([f"{FOLDER}/: {count(len(snapshots.subjects), 'snapshot')}", *words]))
    return _status(errors)


def error_text(error: LinkwrightError, subject: SnapshotSubject) -> str:
    """Returns the message of an error, which begins with the subject unless the error names it."""
    text = render(error)
    names_subject = isinstance(error, ValidationFailed) or subject.title in error.where
    return text if names_subject else f"{subject.title}: {text}"


def _status(errors: list[LinkwrightError]) -> int:
    """Returns the exit status of the worst error: a failed build, then a configuration, then a difference."""
    if any(not isinstance(error, ConfigError | ValidationFailed) for error in errors):
        return 1
    return min((exit_status(error) for error in errors), default=0)
