"""Checks a file for an engine: which of the things in the file the engine does not take."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.stages.formats.xml import tag
from linkwright.stages.mujoco.compile import NotCompiled, compiled_file
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.targets.engines import ENGINES
from linkwright.stages.targets.readers import rows_of
from linkwright.stages.targets.row import ReaderRow
from linkwright.stages.targets.things import THINGS_OF_ROBOTS, names_in_robot
from linkwright.stages.validate.files.run import check_of
from linkwright.stages.validate.reading.documents import ROOTS, read
from linkwright.stages.validate.targets.model_things import MODEL_FINDERS
from linkwright.stages.validate.targets.text_things import TEXT_FINDERS

if TYPE_CHECKING:
    from linkwright.stages.formats.written import Written
    from linkwright.stages.validate.reading.documents import ModelDocument

CODE = "C-TARGET"
"""The code of these checks."""

ENDINGS: Mapping[str, str] = {"urdf": ".urdf", "mjcf": ".xml", "sdf": ".sdf", "usd": ".usda"}
"""Format → ending of a build's files."""

_TITLES: Mapping[str, str] = {"urdf": "a URDF", "mjcf": "an MJCF", "sdf": "an SDF", "usd": "a USD"}
"""Format → its name with an article."""


@dataclass(frozen=True, slots=True)
class _JudgedFile:
    """A file that is judged, as far as it is known."""

    document: "ModelDocument | None"
    """The text, if it is XML."""

    model: Any
    """The compiled model, if the engine has MuJoCo compile the file."""

    written: "Written | None"
    """The robot that the file was written from, if it is known."""

    def findings(self, row: ReaderRow) -> Iterator[Finding]:
        """Yields findings on a row's thing in this file, from the model, else the text, else the robot."""
        find_in_text = TEXT_FINDERS.get((row.format, row.thing))
        if row.thing in MODEL_FINDERS and self.model is not None:
            yield from MODEL_FINDERS[row.thing](self.model)
        elif find_in_text is not None and self.document is not None:
            yield from find_in_text(self.document)
        elif self.written is not None and row.thing not in MODEL_FINDERS:
            names = names_in_robot(row, self.written.robot, self.written.shapes)
            yield from (Finding(name, "", "") for name in names)


def form_of(path: Path) -> str | None:
    """Returns the format of a file by its root element; for a USD, by its ending."""
    return _form(path, None if path.suffix == ENDINGS["usd"] else read(path))


def judge_file(
    target: str, path: Path, version: str | None = None, written: "Written | None" = None
) -> tuple[Check, ...]:
    """Returns the check of a file for a target, and a warning for things that the engine leaves out.

    A file of a build gets no warning for things of its robot, since the build's report has them. The check
    fails for a format that the engine does not read, and for a file that MuJoCo does not compile if the
    engine needs that. `version`: the version of MuJoCo, None for the engine's own; `written`: the robot of
    the build.
    """
    target_text = f"{target}:{version}" if version else target
    name, engine = f"target {target_text}", ENGINES[target]
    reader = engine.readers[0]
    document = None if path.suffix == ENDINGS["usd"] else read(path)
    form = _form(path, document)
    if form is None:
        return (_failed_check(path, name, "it is neither a URDF nor an MJCF nor an SDF"),)
    if form not in engine.reads:
        return (
            _failed_check(path, name, f"{reader} reads {_in_words(engine.reads)}; this is {_TITLES[form]}"),
        )
    model = None
    if engine.mujoco is not None:
        try:
            model = compiled_file(path)
        except NotCompiled as error:
            return (_failed_check(path, name, f"MuJoCo does not compile it: {error}"),)
    judged_file, rows = _JudgedFile(document, model, written), [*rows_of(target, form, version)]
    passed = f"{reader} takes all that it has"
    error_findings = _findings([row for row in rows if row.response != "stated"], judged_file)
    # The report of a build has the things of its robot that are left out.
    stated_rows = [
        row
        for row in rows
        if row.response == "stated" and (written is None or row.thing not in THINGS_OF_ROBOTS)
    ]
    warning_findings = _findings(stated_rows, judged_file)
    checks = [check_of(path, name, CODE, "error", error_findings, passed)]
    if warning_findings:
        checks.append(check_of(path, f"left out by {target_text}", CODE, "warning", warning_findings, passed))
    return tuple(checks)


def message(row: ReaderRow) -> str:
    """Returns the sentence of a finding: the reader, the thing, and what the reader does with it."""
    return f"{row.reader} {row.version}, {row.thing}: {row.does} ({row.evidence})"


def _form(path: Path, document: "ModelDocument | None") -> str | None:
    """Returns the format of a file with this text; None if it is unknown."""
    if document is None:
        return "usd" if path.suffix == ENDINGS["usd"] else None
    return {**ROOTS, "sdf": "sdf"}.get(tag(document.root))


def _failed_check(path: Path, name: str, detail: str) -> Check:
    return Check(f"{path.name}: {name}", False, detail, code=CODE)


def _in_words(forms: tuple[str, ...]) -> str:
    return " or ".join(form.upper() for form in forms)


def _findings(rows: list[ReaderRow], judged_file: _JudgedFile) -> list[Finding]:
    return [
        Finding(thing.element, thing.attribute, f"{thing.message}{message(row)}")
        for row in rows
        for thing in judged_file.findings(row)
    ]
