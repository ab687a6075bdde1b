"""What the checkers of other makers print, as one opinion."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from linkwright.stages.robot.check import Finding


@dataclass(frozen=True, slots=True)
class Opinion:
    """`errors` and `warnings` of a checker on one file; its own `words`."""

    errors: tuple[Finding, ...]
    warnings: tuple[Finding, ...]
    words: str = ""


def of_simcheck(output: str, _: Path) -> Opinion:
    """Of `simcheck check --format json`: a list with one object for each file."""
    (report,) = json.loads(output)
    found = [one for result in report["results"] for one in result["findings"]]
    named = {level: _findings(found, "severity", level, "target", "check") for level in ("error", "warning")}
    return Opinion(named["error"], named["warning"], f"{report['verdict']}, score {report['score']:g}")


def of_mjcf_doctor(output: str, _: Path) -> Opinion:
    """Of `mjcf-doctor check --json`: a list with one object for each file, after words for people."""
    (report,) = json.loads(output[output.index("\n[\n") + 1 :])
    levels = {one["level"] for one in report["findings"]} - {"INFO", "WARN", "WARNING"}
    errors = tuple(
        finding
        for level in sorted(levels)
        for finding in _findings(report["findings"], "level", level, "subject", "code")
    )
    warnings = tuple(
        finding
        for level in ("WARN", "WARNING")
        for finding in _findings(report["findings"], "level", level, "subject", "code")
    )
    return Opinion(errors, warnings)


def of_urdf_validator(_: str, folder: Path) -> Opinion:
    """Of the report that `urdf_validate --output-dir` writes."""
    (path,) = folder.glob("*_validation.json")
    report = json.loads(path.read_text(encoding="utf-8"))
    errors, warnings = (_texts(report.get(name)) for name in ("critical_issues", "warnings"))
    schema = report.get("schema") or {}
    known = {one.message for one in (*errors, *warnings)}
    errors += tuple(one for one in _texts(schema.get("critical_issues")) if one.message not in known)
    return Opinion(errors, warnings, str(report.get("overall_status", "")))


def _findings(
    found: list[dict[str, Any]], key: str, level: str, target: str, code: str
) -> tuple[Finding, ...]:
    return tuple(
        Finding(str(one.get(target) or ""), "", f"{one.get('message', '')} ({one.get(code, '')})")
        for one in found
        if one.get(key) == level
    )


def _texts(found: Any) -> tuple[Finding, ...]:
    texts = [one if isinstance(one, str) else json.dumps(one, sort_keys=True) for one in found or ()]
    return tuple(Finding(_element(text), "", text) for text in texts)


def _element(text: str) -> str:
    """The first name in quotes: the tool names links and joints so."""
    pieces = text.split("'")
    return pieces[1] if len(pieces) > 2 else ""
