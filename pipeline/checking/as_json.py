"""Writes the verdict of checks as JSON for programs, and reads such JSON as a baseline.

    {
      "format": "linkwright-check", "version": 1,
      "place": what was checked, as it was named,
      "robot": the name of the robot that the files were compared with, null without a robot.json,
      "level": "quick" | "standard" | "strict",
      "passed": whether the exit status is 0,
      "counts": {"checks", "passed", "warnings", "failed", "known"},
      "notes": [text, ...],
      "checks": [
        {
          "code": "C-...", its row of stages/CHECKS.md,
          "name": unique among the checks, with the file in front where it is of one: "arm.urdf: mass",
          "file": path below the folder, null for none,
          "level": "error" | "warning",
          "passed": whether it passes,
          "known": whether all its findings are in the baseline,
          "detail": what was measured, in words,
          "value", "limit": numbers, null where the check has none or they are infinite,
          "hint": what to do, null for nothing,
          "findings": [
            {"element": 'joint "elbow"', "attribute": "range" or "", "message": text,
             "line": its line in the file, null where it is not found, "known": whether the baseline has it}
          ]
        }
      ]
    }

Keys may be added in the same version. A finding is known by `code`, `name`, `element` and `attribute`.
"""

import json
import math
from pathlib import Path
from typing import Any

from linkwright.pipeline.checking.lines import ElementLines
from linkwright.pipeline.checking.verdict import Issue, Verdict, file_of, issues
from linkwright.pipeline.errors import OutputError, reason
from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.system.regular_files import FileTooLarge, content

FORMAT, VERSION = "linkwright-check", 1
MAX_BASELINE_BYTES = 1 << 27
"""Largest size of a baseline [bytes]."""

_HINT = "linkwright check --json DIR > baseline.json writes one"


def as_json(verdict: Verdict) -> str:
    """Returns the verdict in the form that the text of this module describes."""
    failed = [check for check in verdict.checks if verdict.is_wrong(check)]
    warnings = [check for check in verdict.checks if not check.passed and not verdict.is_wrong(check)]
    lines = ElementLines(Path(verdict.folder))
    table = {
        "format": FORMAT,
        "version": VERSION,
        "place": verdict.place,
        "robot": verdict.robot or None,
        "level": verdict.level,
        "passed": verdict.passed,
        "counts": {
            "checks": len(verdict.checks),
            "passed": sum(check.passed for check in verdict.checks),
            "warnings": len(warnings),
            "failed": len(failed),
            "known": verdict.seen_before,
        },
        "notes": list(verdict.notes),
        "checks": [_check(check, verdict, lines) for check in verdict.checks],
    }
    return json.dumps(table, indent=2, ensure_ascii=False, allow_nan=False)


def baseline(file: str) -> frozenset[Issue]:
    """Returns the issues in a file that `as_json` wrote. Raises OutputError for any other file."""
    try:
        table = json.loads(content(Path(file), MAX_BASELINE_BYTES))
    except FileTooLarge:
        msg = f"the baseline is longer than {MAX_BASELINE_BYTES >> 20} MB"
        raise OutputError(msg, file, _HINT) from None
    except OSError as error:
        raise OutputError(f"the baseline cannot be read: {reason(error)}", file, _HINT) from None
    except (ValueError, RecursionError) as error:
        raise OutputError(f"the baseline is not JSON: {error}", file, _HINT) from None
    if not isinstance(table, dict) or (table.get("format"), table.get("version")) != (FORMAT, VERSION):
        raise OutputError(f"the baseline is not a {FORMAT} of version {VERSION}", file, _HINT)
    try:
        return frozenset(_issues(table))
    except (KeyError, TypeError, AttributeError):
        raise OutputError("the baseline has checks that cannot be read", file, _HINT) from None


def _issues(table: dict[str, Any]) -> list[Issue]:
    all_issues: list[Issue] = []
    for check in table["checks"]:
        if not check["passed"]:
            entries = check["findings"] or [{"element": "", "attribute": ""}]
            all_issues += [
                (check["code"], check["name"], entry["element"], entry["attribute"]) for entry in entries
            ]
    return all_issues


def _check(check: Check, verdict: Verdict, lines: ElementLines) -> dict[str, Any]:
    file, _ = file_of(check)
    pairs = zip(check.findings, issues(check), strict=False)
    return {
        "code": check.code,
        "name": check.name,
        "file": file or None,
        "level": check.level,
        "passed": check.passed,
        "known": verdict.is_known(check),
        "detail": check.detail,
        "value": _number(check.value),
        "limit": _number(check.limit),
        "hint": None if check.passed else remedy(check.code) or None,
        "findings": [
            {
                "element": problem.element,
                "attribute": problem.attribute,
                "message": problem.message,
                "line": lines.of(file, problem.element, problem.attribute),
                "known": issue in (verdict.baseline or ()),
            }
            for problem, issue in pairs
        ],
    }


def _number(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
