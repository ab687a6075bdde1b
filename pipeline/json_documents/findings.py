"""Chooses the worst diagnostics of a build for a document."""

from collections.abc import Iterable
from dataclasses import dataclass

from linkwright.stages.robot.errors import Diagnostic

MAX_DIAGNOSTICS = 3
"""Largest number of diagnostics of a code in a document, besides those whose hint has YAML to paste."""

_LEVELS = ("error", "warning", "info")
"""The levels, the gravest first."""


@dataclass(frozen=True)
class DiagnosticDocument:
    """A finding about the source or the configuration.

    code: a stable code: its first letter is its level, and `linkwright explain CODE` explains it.
    level: `error`, `warning` or `info`.
    where: the place: a key, a file, a CAD path, a link or joint; may be empty.
    message: the finding.
    hint: what to do, often with YAML to paste after its first line; may be empty.
    """

    code: str
    level: str
    where: str
    message: str
    hint: str


def worst(diagnostics: Iterable[Diagnostic], *, whole: bool) -> tuple[DiagnosticDocument, ...]:
    """Returns errors, then warnings, at most MAX_DIAGNOSTICS of each code, and more if they have YAML to
    paste; if `whole`, all diagnostics."""
    counts_by_code: dict[str, int] = {}
    selection = []
    for diagnostic in diagnostics:
        counts_by_code[diagnostic.code] = number = counts_by_code.get(diagnostic.code, 0) + 1
        is_grave = diagnostic.level != "info" and (number <= MAX_DIAGNOSTICS or "\n" in diagnostic.hint)
        if whole or is_grave:
            selection.append(diagnostic)
    selection.sort(key=lambda diagnostic: _LEVELS.index(diagnostic.level))
    return tuple(map(_document, selection))


def counts(diagnostics: Iterable[Diagnostic]) -> dict[str, int]:
    """Returns the number of diagnostics of each level."""
    levels = [diagnostic.level for diagnostic in diagnostics]
    return {level: levels.count(level) for level in _LEVELS}


def _document(diagnostic: Diagnostic) -> DiagnosticDocument:
    texts = diagnostic.where, diagnostic.message, diagnostic.hint
    return DiagnosticDocument(diagnostic.code, diagnostic.level, *texts)
