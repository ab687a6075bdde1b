"""The results of the checks of a folder or file, and which of them fail."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from linkwright.stages.robot.check import Check, Finding

Issue = tuple[str, str, str, str]
"""What a finding is known by again: the check's code and name, the element and the attribute. Its figures may
change without its being another."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """`place`: the folder or file, as the user named it; `folder`: that of the files that the checks name;
    `robot`: the name of the robot that they were compared with, "" for none; `level`: that of the checks.
    `notes`: what a reader must know, a sentence each. `known`: issues of the baseline; None without one.
    """

    place: str
    folder: str
    robot: str
    level: str
    checks: tuple[Check, ...]
    notes: tuple[str, ...] = ()
    known: frozenset[Issue] | None = None

    @property
    def passed(self) -> bool:
        """Whether nothing fails but what is known."""
        return not any(self.fails(check) for check in self.checks)

    def fails(self, check: Check) -> bool:
        """Whether a check does not pass for a reason that is not known."""
        return self.is_wrong(check) and any(issue not in (self.known or ()) for issue in issues(check))

    def is_wrong(self, check: Check) -> bool:
        """Whether a check does not pass that must: with `strict` also where it is a warning."""
        return not check.passed and (check.level == "error" or self.level == "strict")

    def is_known(self, check: Check) -> bool:
        """Whether a check does not pass, and all that it found is known."""
        return not check.passed and all(issue in (self.known or ()) for issue in issues(check))

    def news(self, check: Check) -> Check:
        """A check with only those of its findings that are not known."""
        pairs = zip(check.findings, issues(check), strict=False)
        return replace(check, findings=tuple(one for one, issue in pairs if issue not in (self.known or ())))

    @property
    def seen_before(self) -> int:
        """How many findings are known."""
        return sum(issue in (self.known or ()) for check in self.checks for issue in issues(check))


def issues(check: Check) -> list[Issue]:
    """What a check found, in the order of its findings; itself where it names no element. None of one that
    passes."""
    if check.passed:
        return []
    found = [(check.code, check.name, one.element, one.attribute) for one in check.findings]
    return found or [(check.code, check.name, "", "")]


def file_of(check: Check) -> tuple[str, str]:
    """The file that a check is of, "" for none, and what it is called besides."""
    file, colon, title = check.name.partition(": ")
    return (file, title) if colon else ("", file)


def told(check: Check) -> Iterator[Finding]:
    """What a check found: what it measured, as a whole, where it names no element."""
    yield from check.findings or [Finding("", "", check.detail)]
