"""Checks that the files of a robot exist."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import named

CODE = "C-PRESENT"


def present(folder: Path, files: Iterable[str]) -> Iterator[Check]:
    """Yields a single check of all files; nothing without files."""
    paths = list(files)
    missing = [path for path in paths if not (folder / path).is_file()]
    detail = f"missing: {', '.join(missing)}" if missing else f"{count(len(paths), 'file')} of robot.json"
    message = "robot.json lists this file, and it is not there"
    findings = tuple(Finding(named("file", path), "", message) for path in missing)
    if paths:
        name, number = "robot.json: files", float(len(missing))
        yield Check(name, not missing, detail, number, 0.0, CODE, "error", findings)
