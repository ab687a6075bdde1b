"""The sink of diagnostics: what a stage finds on its way, and the errors that stop it, reported together."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from stages.robot.errors import AssemblyError, Diagnostic
from stages.robot.plural import count


@dataclass(slots=True)
class Diagnostics:
    """`found` goes to the report with the robot; `problems` (codes E-) end the build."""

    found: list[Diagnostic] = field(default_factory=list)
    problems: list[Diagnostic] = field(default_factory=list)

    def report(self, code: str, message: str, where: str = "", hint: str = "") -> None:
        """Adds one diagnostic; a code that starts with E- is a problem."""
        self.add([Diagnostic(code, message, where, hint)])

    def add(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Adds diagnostics that were made elsewhere."""
        for one in diagnostics:
            (self.problems if one.level == "error" else self.found).append(one)

    def raise_errors(self) -> None:
        """AssemblyError with every problem so far, if there is any."""
        if self.problems:
            msg = f"the assembly cannot be built: {count(len(self.problems), 'problem')}"
            raise AssemblyError(msg, problems=sorted(self.problems, key=lambda p: (p.code, p.where)))
