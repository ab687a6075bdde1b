"""Defines the document of `linkwright check`."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.stages.formats.robot_json.codec import Key


@dataclass(frozen=True)
class FindingDocument:
    """A finding of a check.

    element: an element of the file by tag and name, such as `joint "elbow"`; may be empty.
    attribute: an attribute of the element; may be empty.
    message: the finding.
    line: the line of the element in the file; null if it is not found.
    known: whether the baseline has it.
    """

    element: str
    attribute: str
    message: str
    line: int | None
    is_known: Annotated[bool, Key("known")]


@dataclass(frozen=True)
class CheckResult:
    """A check, whether it passed or not.

    code: its row of CHECKS.md; `linkwright explain CODE` explains it.
    name: unique among the checks, with the file in front if it is about a single file: `arm.urdf: mass`.
    file: the file's path below the folder; null if it is about no single file.
    level: what it means if the check does not pass: error or warning.
    passed: whether it passes.
    known: whether all its findings are in the baseline.
    detail: what was measured, in words.
    value: the measured number; null if the check has none or it is infinite.
    limit: the limit of the number; null if the check has none or it is infinite.
    hint: what to do; null for nothing.
    findings: its findings, the worst first.
    """

    code: str
    name: str
    file: str | None
    level: str
    passed: bool
    is_known: Annotated[bool, Key("known")]
    detail: str
    value: float | None
    limit: float | None
    hint: str | None
    findings: tuple[FindingDocument, ...]


@dataclass(frozen=True)
class CheckCounts:
    """The numbers of checks and findings.

    checks: all checks.
    passed: the checks that passed.
    warnings: the checks that do not pass, but do not fail.
    failed: the checks that fail.
    known: the findings that the baseline has.
    """

    checks: int
    passed: int
    warnings: int
    failed: int
    known_findings: Annotated[int, Key("known")]


@dataclass(frozen=True)
class CheckDocument(CommandDocument):
    """The results of checks of files (`linkwright check`). With `--baseline` a later check reads it: a
    finding is known by `code`, `name`, `element` and `attribute`.

    exit_status: 0: passed; 3: a check failed.
    place: the folder or file as it was named.
    robot: the name of the robot that the files were compared with; null without a robot.json.
    level: `quick`, `standard` or `strict`.
    passed: whether no check fails, except for known findings.
    counts: numbers of checks.
    notes: sentences that a reader of the results must know.
    checks: all checks.
    """

    FORMAT: ClassVar[str] = "linkwright-check"

    exit_status: int
    place: str
    robot: str | None
    level: str
    passed: bool
    counts: CheckCounts
    notes: tuple[str, ...]
    checks: tuple[CheckResult, ...]
