"""The rows of the tables of checks."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.validate.compiled import CheckFunction, FileKind
from linkwright.stages.validate.reading.documents import ModelDocument


@dataclass(frozen=True, slots=True)
class ModelCheck:
    """A check of a compiled model. `code`: of its results that have none of their own; `title`: of the result
    that says that it broke off; `files`: which it is for."""

    code: str
    title: str
    function: CheckFunction
    files: tuple[FileKind, ...]


def _error(_: ModelDocument) -> CheckLevel:
    return "error"


@dataclass(frozen=True, slots=True)
class TextCheck:
    """A check of the text of a model. `passed`: what it says where there is nothing to find; `level`: of what
    it finds."""

    code: str
    title: str
    function: Callable[[ModelDocument], Iterable[Finding]]
    passed: str
    level: Callable[[ModelDocument], CheckLevel] = _error


@dataclass(frozen=True, slots=True)
class FormatCheck:
    """The checks of a file that no engine reads, by its ending. `function`: called with the file, the robot,
    and whether only that it can be read is asked."""

    code: str
    ending: str
    function: Callable[[Path, Written, bool], Iterable[Check]]
