"""The sink of diagnostics: what a stage finds on its way, and the errors that stop it, reported together."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from linkwright.stages.robot.errors import AssemblyError, Diagnostic
from linkwright.stages.robot.text.plural import count


@dataclass(slots=True)
class Diagnostics:
    """`found` goes to the report with the robot; `problems` (codes E-) end the build. `optional`: key that
    holds globs → those of its globs that may match nothing."""

    found: list[Diagnostic] = field(default_factory=list)
    problems: list[Diagnostic] = field(default_factory=list)
    optional: Mapping[Any, Sequence[str]] = field(default_factory=dict)

    def report(self, code: str, message: str, where: str = "", hint: str = "") -> None:
        """Adds one diagnostic; a code that starts with E- is a problem."""
        self.add([Diagnostic(code, message, where, hint)])

    def unmatched(self, code: str, message: str, where: str, hint: str, glob: str) -> None:
        """Adds a glob that matches nothing at the key `where`: I-GLOB if it is optional; "*" may match
        nothing without a word."""
        if glob in self._optional(where):
            self.report("I-GLOB", message, where, "it may: a preset has it, or the key `optional`")
        elif glob != "*":
            self.report(code, message, where, hint)

    def _optional(self, where: str) -> Sequence[str]:
        """The optional globs of the key `where`, or of the section that it is in."""
        return [*self.optional.get(where, ()), *self.optional.get(where.partition(".")[0], ())]

    def add(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Adds diagnostics that were made elsewhere."""
        for one in diagnostics:
            (self.problems if one.level == "error" else self.found).append(one)

    def raise_errors(self) -> None:
        """AssemblyError with every problem so far, if there is any."""
        if self.problems:
            msg = f"the assembly cannot be built: {count(len(self.problems), 'problem')}"
            raise AssemblyError(msg, problems=sorted(self.problems, key=lambda p: (p.code, p.where)))
