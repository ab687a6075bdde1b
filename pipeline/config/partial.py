"""Composes an invalid configuration as far as possible, so that all errors are reported in one run."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from linkwright.pipeline.errors import Diagnostic


@dataclass(slots=True)
class Draft:
    """The state of an incomplete composition."""

    problems: list[Diagnostic] = field(default_factory=list)
    """The problems so far."""
    without: set[str] = field(default_factory=set)
    """The groups whose choice was ignored."""
    lost: set[str] = field(default_factory=set)
    """The keys with an unreadable value on the command line."""

    @classmethod
    def of(cls, problems: Iterable[Diagnostic], bad: Mapping[str, Sequence[Diagnostic]]) -> "Draft":
        """Creates the draft of a command line. `problems`: of its arguments; `bad`: the problems of invalid
        choices, by group."""
        typed = list(problems)
        lost = {problem.where.lstrip("+~").partition("=")[0] for problem in typed}
        return cls([*typed, *(problem for of_group in bad.values() for problem in of_group)], set(bad), lost)

    def add(self, problem: Diagnostic) -> None:
        """Adds a problem unless the draft already has it."""
        if problem not in self.problems:
            self.problems.append(problem)

    def unsure(self, problem: Diagnostic) -> bool:
        """Tells whether a problem may only follow from an ignored choice or an unreadable value."""
        missing = problem.code == "E-MISSING"
        if missing and problem.where in self.lost:
            return True
        if not re.match(r"source\b", problem.where):
            return False
        return "source" in self.without or (missing and "robot" in self.without)
