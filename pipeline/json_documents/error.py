"""Defines the document of a command that an error ended."""

from dataclasses import dataclass
from typing import ClassVar

from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.json_documents.findings import DiagnosticDocument, worst


@dataclass(frozen=True)
class ErrorDocument(CommandDocument):
    """A command that an error ended.

    exit_status: 1: failed; 2: wrong usage or configuration, nothing was done; 130: interrupted.
    verb: the verb; `build` or `sweep` for a command line without a verb.
    type: the class of the error: `UsageError`, a class of the tree of errors such as `ConfigError`,
        `NotFound` or `MissingMass`, or a class of Python.
    message: the error, in a sentence.
    where: the place: a key, a file, a CAD path; may be empty.
    hint: what to do; may be empty.
    problems: the problems that the error lists: at most three of a code and all with YAML to paste; with
        `-v`, and for a wrong configuration, all.
    count: the number of all problems.
    notes: further lines: the API calls made, the source, the page of the failed build.
    """

    FORMAT: ClassVar[str] = "linkwright-error"

    exit_status: int
    verb: str
    type: str
    message: str
    where: str
    hint: str
    problems: tuple[DiagnosticDocument, ...]
    count: int
    notes: tuple[str, ...]


def error_document(
    error: BaseException, status: int, verb: str, *, message: str, hint: str, whole: bool
) -> ErrorDocument:
    """Returns the document of a command that `error` ended. `message` and `hint`: the texts of an error whose
    class is not Linkwright's; `whole`: whether to list all problems of a stage."""
    problems = tuple(getattr(error, "problems", ()))
    return ErrorDocument(
        exit_status=status,
        verb=verb,
        type=type(error).__name__,
        message=getattr(error, "message", message),
        where=getattr(error, "where", ""),
        hint=getattr(error, "hint", hint),
        problems=worst(problems, whole=whole or status == 2),
        count=len(problems),
        notes=tuple(getattr(error, "__notes__", ())),
    )
