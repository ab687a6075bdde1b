"""Checks that the files of a robot exist."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import named

CODE = "C-PRESENT"


def check_files_exist(folder: Path, files: Iterable[str]) -> Iterator[Check]:
    """Yields one check of all files; nothing if there are no files."""
    paths = list(files)
    missing = [path for path in paths if not (folder / path).is_file()]
    detail = f"missing: {', '.join(missing)}" if missing else f"{count(len(paths), 'file')} of robot.json"
    message = "robot.json lists this file, but it does not exist"
    findings = tuple(Finding(named("file", path), "", message) for path in missing)
    if paths:
        yield Check(
            "robot.json: files",
            passed=not missing,
            detail=detail,
            value=float(len(missing)),
            limit=0.0,
            code=CODE,
            level="error",
            findings=findings,
        )
