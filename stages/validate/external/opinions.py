"""Reads the output of other makers' checkers into a common form."""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from linkwright.stages.robot.check import Finding


@dataclass(frozen=True, slots=True)
class Opinion:
    """The opinion of a checker on a file."""

    errors: tuple[Finding, ...]
    warnings: tuple[Finding, ...]
    words: str = ""
    """A summary by the checker."""


class NoVerdict(Exception):
    """The checker could not judge. The message says why."""


def read_simcheck(output: str, _: Path) -> Opinion:
    """Reads `simcheck check --format json`: a list with one object for each file."""
    (report,) = json.loads(output)
    entries = [entry for result in report["results"] for entry in result["findings"]]
    by_level = {
        level: _findings(entries, "severity", level, "target", "check") for level in ("error", "warning")
    }
    return Opinion(by_level["error"], by_level["warning"], f"{report['verdict']}, score {report['score']:g}")


def read_mjcf_doctor(output: str, _: Path) -> Opinion:
    """Reads `mjcf-doctor check --json`: a list with one object for each file, after a text for people."""
    (report,) = json.loads(output[output.index("\n[\n") + 1 :])
    levels = {entry["level"] for entry in report["findings"]} - {"INFO", "WARN", "WARNING"}
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


def read_urdf_validator(_: str, folder: Path) -> Opinion:
    """Reads the report that `urdf_validate --output-dir` writes."""
    (path,) = folder.glob("*_validation.json")
    report = json.loads(path.read_text(encoding="utf-8"))
    errors, warnings = (_text_findings(report.get(name)) for name in ("critical_issues", "warnings"))
    schema = report.get("schema") or {}
    messages = {finding.message for finding in (*errors, *warnings)}
    errors += tuple(
        finding
        for finding in _text_findings(schema.get("critical_issues"))
        if finding.message not in messages
    )
    return Opinion(errors, warnings, str(report.get("overall_status", "")))


SIMREADY_REPORT = "simready.json"
"""The file that `simready-validate --output` writes here."""


def read_simready(output: str, folder: Path) -> Opinion:
    """Reads the report that `simready-validate --output` writes, on the features of a profile. An optional
    feature that is not met is not an error. Raises NoVerdict if the profile is unknown."""
    path = folder / SIMREADY_REPORT
    results = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    if not results:
        hint = "is simready-foundation-tier-core installed beside it?"
        raise NoVerdict(next((line.strip() for line in output.splitlines() if "ERROR" in line), hint))
    (result,) = results.values()
    features = result["features_summary"]
    failed = {name: feature for name, feature in features.items() if not feature["passed"]}
    errors = tuple(
        Finding("", name, f"{message} ({requirement})")
        for name, feature in sorted(failed.items())
        if feature["blocking_failure"]
        for requirement, message in _failed_requirements(feature)
    )
    optional = sorted(name for name, feature in failed.items() if not feature["blocking_failure"])
    words = f"{result['profile_id']} {result['profile_version']}, {len(features) - len(failed)} of "
    words += f"{len(features)} features"
    return Opinion(
        errors, (), f"{words}; not met, and optional: {', '.join(optional)}" if optional else words
    )


def _failed_requirements(feature: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yields the requirements that a feature fails, each with its first message and the number of others."""
    table = feature.get("requirement_messages") or {}
    messages = json.loads(table) if isinstance(table, str) else table
    codes = re.findall(r"[\w.]+", str(feature.get("failing requirements", "")))
    for code in dict.fromkeys([*codes, *messages]):
        first, *further_messages = messages.get(code) or ["not met"]
        yield code, f"{first}, and {len(further_messages)} more" if further_messages else str(first)


def _findings(
    entries: list[dict[str, Any]], key: str, level: str, target: str, code: str
) -> tuple[Finding, ...]:
    return tuple(
        Finding(str(entry.get(target) or ""), "", f"{entry.get('message', '')} ({entry.get(code, '')})")
        for entry in entries
        if entry.get(key) == level
    )


def _text_findings(issues: Any) -> tuple[Finding, ...]:
    texts = [issue if isinstance(issue, str) else json.dumps(issue, sort_keys=True) for issue in issues or ()]
    return tuple(Finding(_element(text), "", text) for text in texts)


def _element(text: str) -> str:
    """Returns the first name in quotes, since the tool quotes the names of links and joints."""
    pieces = text.split("'")
    return pieces[1] if len(pieces) > 2 else ""
