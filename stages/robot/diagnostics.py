"""Collects the diagnostics of a stage, and raises all errors together."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from linkwright.stages.robot.errors import AssemblyError, Diagnostic
from linkwright.stages.robot.text.plural import count


@dataclass(slots=True)
class Diagnostics:
    """The diagnostics of a stage."""

    notes: list[Diagnostic] = field(default_factory=list)
    """Warnings and information, for the report."""
    problems: list[Diagnostic] = field(default_factory=list)
    """Errors (codes E-), which end the build."""
    optional: Mapping[Any, Sequence[str]] = field(default_factory=dict)
    """Configuration key → the globs of the key that may match nothing."""

    def report(self, code: str, message: str, where: str = "", hint: str = "") -> None:
        """Adds a diagnostic; a code that starts with E- is a problem."""
        self.add([Diagnostic(code, message, where, hint)])

    def report_unmatched(self, code: str, message: str, key: str, hint: str, glob: str) -> None:
        """Reports a glob of the key `key` that matches nothing, with I-GLOB if the glob is optional, else
        with `code`. The glob "*" may match nothing and is not reported."""
        if glob in self._optional_globs(key):
            self.report("I-GLOB", message, key, "this is allowed, by a preset or by the key `optional`")
        elif glob != "*":
            self.report(code, message, key, hint)

    def _optional_globs(self, key: str) -> Sequence[str]:
        """Returns the optional globs of `key` and of its section."""
        return [*self.optional.get(key, ()), *self.optional.get(key.partition(".")[0], ())]

    def add(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Adds diagnostics, each to `problems` or `notes` by its level."""
        for diagnostic in diagnostics:
            (self.problems if diagnostic.level == "error" else self.notes).append(diagnostic)

    def raise_errors(self) -> None:
        """Raises AssemblyError with all problems so far, sorted by code and place; nothing without a
        problem."""
        if self.problems:
            msg = f"the assembly cannot be built: {count(len(self.problems), 'problem')}"
            raise AssemblyError(msg, problems=sorted(self.problems, key=_code_and_place))


def _code_and_place(problem: Diagnostic) -> tuple[str, str]:
    return problem.code, problem.where
