"""What the stage finds on its way: findings, and the problems that stop it, all told at once."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from stages.robot.errors import AssemblyError, Diagnostic


@dataclass(slots=True)
class Notes:
    """`found` goes to the report with the robot; `problems` (codes E-) end the build."""

    found: list[Diagnostic] = field(default_factory=list)
    problems: list[Diagnostic] = field(default_factory=list)

    def tell(self, code: str, message: str, where: str = "", hint: str = "") -> None:
        """Takes down one finding; a code that starts with E- is a problem."""
        self.add([Diagnostic(code, message, where, hint)])

    def add(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Takes down findings that were made elsewhere."""
        for one in diagnostics:
            (self.problems if one.level == "error" else self.found).append(one)

    def settle(self) -> None:
        """AssemblyError with every problem so far, if there is any."""
        if self.problems:
            msg = f"the assembly cannot be built: {len(self.problems)} problem(s)"
            raise AssemblyError(msg, problems=sorted(self.problems, key=lambda p: (p.code, p.where)))
