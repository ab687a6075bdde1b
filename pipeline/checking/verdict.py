"""Judges the results of the checks of a folder or file: which of them fail."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from linkwright.stages.robot.check import Check, Finding

Issue = tuple[str, str, str, str]
"""The identity of a finding: the check's code and name, the element and the attribute. Figures do not count,
since they may change between builds."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """The results of the checks of a folder or file."""

    place: str
    """The folder or file as the user named it."""
    folder: str
    """The folder of the files that the checks name."""
    robot: str
    """The name of the robot that the files were compared with; "" if there is none."""
    level: str
    """The level of the checks: quick, standard or strict."""
    checks: tuple[Check, ...]
    notes: tuple[str, ...] = ()
    """Sentences that a reader of the results must know."""
    baseline: frozenset[Issue] | None = None
    """The issues of the baseline; None without a baseline."""

    @property
    def passed(self) -> bool:
        """Tells whether no check fails, apart from issues of the baseline."""
        return not any(self.fails(check) for check in self.checks)

    def fails(self, check: Check) -> bool:
        """Tells whether a check that must pass has an issue that the baseline lacks."""
        return self.is_wrong(check) and any(issue not in (self.baseline or ()) for issue in issues(check))

    def is_wrong(self, check: Check) -> bool:
        """Tells whether a check must pass and does not. At the level `strict`, warnings must pass too."""
        return not check.passed and (check.level == "error" or self.level == "strict")

    def is_known(self, check: Check) -> bool:
        """Tells whether a check does not pass, and all its issues are in the baseline."""
        return not check.passed and all(issue in (self.baseline or ()) for issue in issues(check))

    def with_new_findings(self, check: Check) -> Check:
        """Returns a check with only its new findings."""
        pairs = zip(check.findings, issues(check), strict=False)
        return replace(
            check, findings=tuple(finding for finding, issue in pairs if issue not in (self.baseline or ()))
        )

    @property
    def known_count(self) -> int:
        """The number of known findings."""
        return sum(issue in (self.baseline or ()) for check in self.checks for issue in issues(check))


def issues(check: Check) -> list[Issue]:
    """Returns the issues of a check, in the order of its findings: a single issue if it has no findings, and
    none if it passes."""
    if check.passed:
        return []
    by_finding = [(check.code, check.name, finding.element, finding.attribute) for finding in check.findings]
    return by_finding or [(check.code, check.name, "", "")]


def file_of(check: Check) -> tuple[str, str]:
    """Returns the file that a check is about ("" for none), and the rest of its name."""
    file, colon, title = check.name.partition(": ")
    return (file, title) if colon else ("", file)


def findings_of(check: Check) -> Iterator[Finding]:
    """Yields the findings of a check, or a single finding with its detail if it has none."""
    yield from check.findings or [Finding("", "", check.detail)]
