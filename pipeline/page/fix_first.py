"""Renders the gravest problems of a build, to be fixed first, in a few lines."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from linkwright.pipeline.page.checks import finding_text, outcome, split_name
from linkwright.pipeline.page.codes import level_of, problems_of, to_code
from linkwright.pipeline.page.html.template import rendered, shortened
from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.robot.text.plural import count

MAX_FIXES = 5
"""Largest number of things to fix that are named."""

MAX_LETTERS = 220
"""Largest number of letters in the text about a thing."""

_RANKS = ("error", "failed", "warning", "readiness")
"""Ranks of things to fix, the gravest first."""

_MARKS = {"error": "✕ error", "failed": "✕ failed", "warning": "! warning", "readiness": "+ readiness"}

_READINESS, _MISSING = "C-READINESS", "missing"
"""The code of the check that scores the finished robot, and its word for a point that the robot lacks."""


@dataclass(frozen=True, slots=True)
class Fix:
    """A thing to fix; its texts are plain."""

    rank: str
    """How grave it is: one of the ranks."""
    code: str
    """The code whose meaning explains it."""
    title: str
    finding: str
    to_do: str
    """The remedy; may be a line of Markdown."""
    count: int = 1
    """How often it was found."""


def fixes(tree: Mapping[str, Any]) -> list[Fix]:
    """Returns all things to fix, the gravest first, each kind once; `tree`: the report as plain data."""
    all_fixes = [*_problems(tree), *_checks(tree), *_points(tree)]
    return sorted(all_fixes, key=lambda fix: _RANKS.index(fix.rank))


def fix_first(tree: Mapping[str, Any], all_fixes: list[Fix]) -> str:
    """Renders the section with `all_fixes`; "" if an error with few problems ended the build, since the page
    lists these anyway."""
    error = tree["error"]
    if error is not None and len(error.get("problems", ())) <= MAX_FIXES:
        return ""
    items = [
        {
            "fix": fix,
            "mark": _MARKS[fix.rank],
            "title": to_code(fix.code, fix.title),
            "finding": shortened(fix.finding, MAX_LETTERS),
        }
        for fix in all_fixes[:MAX_FIXES]
    ]
    rest = len(all_fixes) - MAX_FIXES
    more = count(rest, "more thing", "more things") if rest > 0 else ""
    return rendered("fix_first", items=items, more=more, checked=bool(tree["checks"]))


def _problems(tree: Mapping[str, Any]) -> Iterator[Fix]:
    """Yields a fix for each code of an error or a warning."""
    groups: dict[str, list[Mapping[str, Any]]] = {}
    for problem in problems_of(tree):
        if level_of(problem["code"]) in _RANKS:
            groups.setdefault(problem["code"], []).append(problem)
    for code, group in groups.items():
        first = group[0]
        place = f"{first['where']}: " if first["where"] else ""
        to_do = shortened(first["hint"] or remedy(code), MAX_LETTERS)
        yield Fix(level_of(code), code, code, f"{place}{first['message']}", to_do, len(group))


def _checks(tree: Mapping[str, Any]) -> Iterator[Fix]:
    """Yields a fix for each check that did not pass; a check of several files appears once."""
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for check in tree["checks"]:
        if not check["passed"]:
            groups.setdefault((check["code"], split_name(check)[1]), []).append(check)
    for (code, title), group in groups.items():
        files = ", ".join(filter(None, (split_name(check)[0] for check in group)))
        name = f"{title} in {files}" if files else title
        findings = group[0]["findings"]
        finding = finding_text(findings[0]) if findings else group[0]["detail"]
        yield Fix(outcome(group[0]), code, name, finding, remedy(code))


def _points(tree: Mapping[str, Any]) -> Iterator[Fix]:
    """Yields a fix for each point that would raise the score of the finished robot."""
    for check in tree["checks"]:
        if check["code"] == _READINESS and check["table"]:
            for number, point, verdict, *words in check["table"]["rows"]:
                if verdict == _MISSING:
                    title = f"point {number} of sim-readiness"
                    yield Fix("readiness", _READINESS, title, point, shortened(", ".join(words), MAX_LETTERS))
