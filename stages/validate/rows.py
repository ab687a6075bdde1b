"""Defines the rows of the tables of checks."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.validate.compiled import CheckFunction, FileKind
from linkwright.stages.validate.reading.documents import ModelDocument


@dataclass(frozen=True, slots=True)
class ModelCheck:
    """A check of a compiled model."""

    code: str
    """The code of results to which the check itself gives none."""

    title: str
    """The name of the result that reports an exception."""

    function: CheckFunction
    files: tuple[FileKind, ...]
    """The kinds of files that the check judges."""


def _error(_: ModelDocument) -> CheckLevel:
    return "error"


@dataclass(frozen=True, slots=True)
class TextCheck:
    """A check of the text of a model."""

    code: str
    title: str
    function: Callable[[ModelDocument], Iterable[Finding]]
    passed: str
    """The message if there are no findings."""

    level: Callable[[ModelDocument], CheckLevel] = _error
    """Returns the level of the findings."""


@dataclass(frozen=True, slots=True)
class FormatCheck:
    """The checks of a file that no engine reads."""

    code: str
    """The code of all results."""

    ending: str
    """The ending of the file's name, with its dot."""

    function: Callable[[Path, Written, bool], Iterable[Check]]
    """Called with the file, the robot, and whether to check only that the file can be read."""
