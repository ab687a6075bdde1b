"""A row of the table of losses."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from linkwright.stages.export.writer import Case
from linkwright.stages.robot.errors import Diagnostic


@dataclass(frozen=True)
class Loss:
    """A kind of thing that formats cannot express, or have otherwise.

    `codes`: of the diagnostic, by format. `find`: the names of what is lost, or whether anything is. `text`:
    the message, with `{}` where the names go and `{format}` where the format does; `join`: the names as text,
    None where each has a diagnostic of its own.
    """

    codes: Mapping[str, str]
    find: Callable[[Case[Any]], Iterable[str] | bool]
    text: str
    hint: str = ""
    join: Callable[[Iterable[str]], str] | None = ", ".join

    def diagnostics(self, case: Case[Any]) -> Iterator[Diagnostic]:
        """Yields nothing for other formats, and where nothing is lost."""
        if case.format not in self.codes:
            return
        found = self.find(case)
        names = [*found] if not isinstance(found, bool) else [""] * found
        if names and self.join is not None:
            names = [self.join(names)]
        text = self.text.replace("{format}", case.format.upper())
        for name in names:
            yield Diagnostic(self.codes[case.format], text.replace("{}", name), case.where, self.hint)
