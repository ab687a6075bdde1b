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
    ignored_groups: set[str] = field(default_factory=set)
    """The groups whose choice was ignored."""
    unreadable_keys: set[str] = field(default_factory=set)
    """The keys with an unreadable value on the command line."""

    @classmethod
    def of(
        cls, problems: Iterable[Diagnostic], invalid_choices: Mapping[str, Sequence[Diagnostic]]
    ) -> "Draft":
        """Creates the draft of a command line. `problems`: of its arguments; `invalid_choices`: the problems
        of invalid choices, by group."""
        typed = list(problems)
        lost_keys = {problem.where.lstrip("+~").partition("=")[0] for problem in typed}
        return cls(
            [*typed, *(problem for group_problems in invalid_choices.values() for problem in group_problems)],
            set(invalid_choices),
            lost_keys,
        )

    def add(self, problem: Diagnostic) -> None:
        """Adds a problem unless the draft already has it."""
        if problem not in self.problems:
            self.problems.append(problem)

    def is_unsure(self, problem: Diagnostic) -> bool:
        """Tells whether a problem may only follow from an ignored choice or an unreadable value."""
        missing = problem.code == "E-MISSING"
        if missing and problem.where in self.unreadable_keys:
            return True
        if not re.match(r"source\b", problem.where):
            return False
        return "source" in self.ignored_groups or (missing and "robot" in self.ignored_groups)
