"""Converts a verdict of checks to its JSON document, and reads such a document as a baseline."""

import json
from pathlib import Path
from typing import Any

from linkwright.pipeline.checking.lines import ElementLines
from linkwright.pipeline.checking.verdict import Issue, Verdict, file_of, issues
from linkwright.pipeline.errors import OutputError, reason
from linkwright.pipeline.json_documents.check import CheckCounts, CheckDocument, CheckResult, FindingDocument
from linkwright.pipeline.json_documents.document import VERSION
from linkwright.pipeline.reference.codes import remedy
from linkwright.pipeline.reference.exit_status import BUILT, UNMET
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.system.regular_files import FileTooLarge, content

MAX_BASELINE_BYTES = 1 << 27
"""Largest size of a baseline [bytes]."""

_HINT = "linkwright check --json DIR > baseline.json writes one"


def as_document(verdict: Verdict) -> CheckDocument:
    """Returns the document of a verdict."""
    failed = [check for check in verdict.checks if verdict.is_wrong(check)]
    warnings = [check for check in verdict.checks if not check.passed and not verdict.is_wrong(check)]
    lines = ElementLines(Path(verdict.folder))
    return CheckDocument(
        exit_status=BUILT if verdict.passed else UNMET,
        place=verdict.place,
        robot=verdict.robot or None,
        level=verdict.level,
        passed=verdict.passed,
        counts=CheckCounts(
            checks=len(verdict.checks),
            passed=sum(check.passed for check in verdict.checks),
            warnings=len(warnings),
            failed=len(failed),
            known_findings=verdict.known_count,
        ),
        notes=tuple(verdict.notes),
        checks=tuple(_result(check, verdict, lines) for check in verdict.checks),
    )


def baseline(file: str) -> frozenset[Issue]:
    """Returns the issues in a file that has the output of `linkwright check --json`; raises OutputError for
    any other file."""
    try:
        document = json.loads(content(Path(file), MAX_BASELINE_BYTES))
    except FileTooLarge:
        msg = f"the baseline is longer than {MAX_BASELINE_BYTES >> 20} MB"
        raise OutputError(msg, file, _HINT) from None
    except OSError as error:
        raise OutputError(f"the baseline cannot be read: {reason(error)}", file, _HINT) from None
    except (ValueError, RecursionError) as error:
        raise OutputError(f"the baseline is not JSON: {error}", file, _HINT) from None
    expected = (CheckDocument.FORMAT, VERSION)
    if not isinstance(document, dict) or (document.get("format"), document.get("version")) != expected:
        raise OutputError(f"the baseline is not a {expected[0]} of version {VERSION}", file, _HINT)
    try:
        return frozenset(_issues(document))
    except (KeyError, TypeError, AttributeError):
        raise OutputError("the baseline has checks that cannot be read", file, _HINT) from None


def _issues(document: dict[str, Any]) -> list[Issue]:
    """Returns the issues of the failed checks in a document of `check --json`."""
    all_issues: list[Issue] = []
    for check in document["checks"]:
        if not check["passed"]:
            entries = check["findings"] or [{"element": "", "attribute": ""}]
            all_issues += [
                (check["code"], check["name"], entry["element"], entry["attribute"]) for entry in entries
            ]
    return all_issues


def _result(check: Check, verdict: Verdict, lines: ElementLines) -> CheckResult:
    file, _ = file_of(check)
    pairs = zip(check.findings, issues(check), strict=False)
    findings = (
        FindingDocument(
            element=finding.element,
            attribute=finding.attribute,
            message=finding.message,
            line=lines.of(file, finding.element, finding.attribute),
            is_known=issue in (verdict.baseline or ()),
        )
        for finding, issue in pairs
    )
    return CheckResult(
        code=check.code,
        name=check.name,
        file=file or None,
        level=check.level,
        passed=check.passed,
        is_known=verdict.is_known(check),
        detail=check.detail,
        value=check.value,
        limit=check.limit,
        hint=None if check.passed else remedy(check.code) or None,
        findings=tuple(findings),
    )
