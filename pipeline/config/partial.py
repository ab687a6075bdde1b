"""Composes an invalid configuration as far as possible, so that all errors are reported in one run."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from linkwright.pipeline.errors import Diagnostic


@dataclass(slots=True)
class Draft:
    """The state of an incomplete composition.

    `problems`: found so far; `without`: the groups whose choice was ignored; `lost`: the keys with an
    unreadable value on the command line.
    """

    problems: list[Diagnostic] = field(default_factory=list)
    without: set[str] = field(default_factory=set)
    lost: set[str] = field(default_factory=set)

    @classmethod
    def of(cls, known: Iterable[Diagnostic], bad: Mapping[str, Sequence[Diagnostic]]) -> "Draft":
        """The draft of a command line with `known` problems, and `bad` choices by group."""
        problems = list(known)
        lost = {problem.where.lstrip("+~").partition("=")[0] for problem in problems}
        problems += [problem for found in bad.values() for problem in found]
        return cls(problems, set(bad), lost)

    def add(self, problem: Diagnostic) -> None:
        """Adds a problem, unless it is there already."""
        if problem not in self.problems:
            self.problems.append(problem)

    def unsure(self, problem: Diagnostic) -> bool:
        """Whether a problem may only follow from an ignored choice or an unreadable value."""
        missing = problem.code == "E-MISSING"
        if missing and problem.where in self.lost:
            return True
        if not re.match(r"source\b", problem.where):
            return False
        return "source" in self.without or (missing and "robot" in self.without)
