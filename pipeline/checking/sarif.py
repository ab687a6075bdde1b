"""Writes the verdict of checks as SARIF 2.1.0, which code hosts show in a pull request."""

import hashlib
import json
from pathlib import Path, PurePath
from typing import Any
from urllib.parse import quote

from linkwright.pipeline.checking.lines import ElementLines
from linkwright.pipeline.checking.verdict import Verdict, file_of, findings_of, issues
from linkwright.pipeline.reference.codes import explanations, remedy
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.system.install import installed

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"


def as_sarif(verdict: Verdict) -> str:
    """Returns a SARIF log with a rule for each code, and a result for each finding of a failing check."""
    codes = list(dict.fromkeys(check.code for check in verdict.checks))
    lines = ElementLines(Path(verdict.folder))
    results = [
        _result(verdict, check, finding, index, lines)
        for check in verdict.checks
        if not check.passed
        for index, finding in enumerate(findings_of(check))
    ]
    driver = {
        "name": "linkwright",
        "version": installed("linkwright"),
        "rules": [_rule(code) for code in codes],
    }
    run = {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
    log = {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}
    return json.dumps(log, indent=2, ensure_ascii=False) + "\n"


def _rule(code: str) -> dict[str, Any]:
    explanation = explanations().get(code)
    rule: dict[str, Any] = {"id": code}
    if explanation is not None:
        rule |= {
            "shortDescription": {"text": explanation.meaning},
            "help": {"text": remedy(code) or explanation.meaning},
        }
    return rule


def _result(
    verdict: Verdict, check: Check, finding: Finding, index: int, lines: ElementLines
) -> dict[str, Any]:
    file, title = file_of(check)
    issue = issues(check)[index]
    subject = f"{finding.element} {finding.attribute}".strip()
    text = f"{title}: {subject}: {finding.message}" if subject else f"{title}: {finding.message}"
    result: dict[str, Any] = {
        "ruleId": check.code,
        "level": "error" if verdict.is_wrong(check) else "warning",
        "message": {"text": text},
        "partialFingerprints": {"linkwright/v1": hashlib.sha256("\0".join(issue).encode()).hexdigest()},
    }
    if verdict.baseline is not None:
        result["baselineState"] = "unchanged" if issue in verdict.baseline else "new"
    if file:
        line = lines.of(file, finding.element, finding.attribute)
        uri = _uri(PurePath(verdict.folder) / file)
        location: dict[str, Any] = {"artifactLocation": {"uri": uri}}
        if line is not None:
            location["region"] = {"startLine": line}
        result["locations"] = [{"physicalLocation": location}]
    return result


def _uri(path: PurePath) -> str:
    """Returns a path as a URI: a relative reference, or a `file:` URI for an absolute path."""
    return path.as_uri() if path.is_absolute() else quote(path.as_posix())
