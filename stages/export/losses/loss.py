"""Defines a row of the table of losses."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from linkwright.stages.export.writer import Case
from linkwright.stages.robot.errors import Diagnostic


@dataclass(frozen=True)
class Loss:
    """A feature that formats cannot express, or express differently."""

    codes: Mapping[str, str]
    """Format → the code of the diagnostic."""

    find: Callable[[Case[Any]], Iterable[str] | bool]
    """Returns the names of the lost things, or whether anything is lost."""

    text: str
    """The message, with placeholders `{}` for the names and `{format}` for the format."""

    hint: str = ""

    join: Callable[[Iterable[str]], str] | None = ", ".join
    """Joins the names for the message; None to report each name separately."""

    def diagnostics(self, case: Case[Any]) -> Iterator[Diagnostic]:
        """Yields the diagnostics of this loss; none if the format has no code for it, or if nothing is
        lost."""
        if case.format not in self.codes:
            return
        losses = self.find(case)
        names = [*losses] if not isinstance(losses, bool) else [""] * losses
        if names and self.join is not None:
            names = [self.join(names)]
        text = self.text.replace("{format}", case.format.upper())
        for name in names:
            yield Diagnostic(self.codes[case.format], text.replace("{}", name), case.where, self.hint)
