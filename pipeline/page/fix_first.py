"""What to fix first: the gravest of all that a build found, in a few lines."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from linkwright.pipeline.page.checks import outcome, said, split_name
from linkwright.pipeline.page.codes import level_of, problems_of, to_code
from linkwright.pipeline.page.html.template import rendered, shortened
from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.robot.text.plural import count

MOST = 5
"""So many things are named."""

_LETTERS = 220
"""So long is what is said of one."""

_RANKS = ("error", "failed", "warning", "readiness")
"""The gravest first."""

_MARKS = {"error": "✕ error", "failed": "✕ failed", "warning": "! warning", "readiness": "+ readiness"}

_READINESS, _MISSING = "C-READINESS", "missing"
"""The code of the check that scores the finished robot, and its word for a point that the robot lacks."""


@dataclass(frozen=True, slots=True)
class Fix:
    """One thing to fix. `rank`: how grave; `code`: what explains it; `title`, `found`, `to_do`: plain text,
    `to_do` may be Markdown of one line; `count`: how often it was found."""

    rank: str
    code: str
    title: str
    found: str
    to_do: str
    count: int = 1


def fixes(tree: Mapping[str, Any]) -> list[Fix]:
    """All that there is to fix, the gravest first, each kind of it once; `tree`: the report as plain data."""
    found = [*_problems(tree), *_checks(tree), *_points(tree)]
    return sorted(found, key=lambda fix: _RANKS.index(fix.rank))


def fix_first(tree: Mapping[str, Any], found: list[Fix]) -> str:
    """The section, of what `fixes` found; nothing where an error with a few problems is all that is known."""
    error = tree["error"]
    if error is not None and len(error.get("problems", ())) <= MOST:
        return ""
    items = [
        {
            "fix": fix,
            "mark": _MARKS[fix.rank],
            "title": to_code(fix.code, fix.title),
            "found": shortened(fix.found, _LETTERS),
        }
        for fix in found[:MOST]
    ]
    rest = len(found) - MOST
    more = count(rest, "more thing", "more things") if rest > 0 else ""
    return rendered("fix_first", items=items, more=more, checked=bool(tree["checks"]))


def _problems(tree: Mapping[str, Any]) -> Iterator[Fix]:
    """The errors and warnings, those of one code together."""
    groups: dict[str, list[Mapping[str, Any]]] = {}
    for one in problems_of(tree):
        if level_of(one["code"]) in _RANKS:
            groups.setdefault(one["code"], []).append(one)
    for code, group in groups.items():
        first = group[0]
        place = f"{first['where']}: " if first["where"] else ""
        to_do = shortened(first["hint"] or remedy(code), _LETTERS)
        yield Fix(level_of(code), code, code, f"{place}{first['message']}", to_do, len(group))


def _checks(tree: Mapping[str, Any]) -> Iterator[Fix]:
    """The checks that did not pass, one of several files once."""
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for check in tree["checks"]:
        if not check["passed"]:
            groups.setdefault((check["code"], split_name(check)[1]), []).append(check)
    for (code, title), group in groups.items():
        files = ", ".join(filter(None, (split_name(check)[0] for check in group)))
        name = f"{title} in {files}" if files else title
        findings = group[0]["findings"]
        found = said(findings[0]) if findings else group[0]["detail"]
        yield Fix(outcome(group[0]), code, name, found, remedy(code))


def _points(tree: Mapping[str, Any]) -> Iterator[Fix]:
    """What would raise the score of the finished robot."""
    for check in tree["checks"]:
        if check["code"] == _READINESS and check["table"]:
            for number, what, verdict, *words in check["table"]["rows"]:
                if verdict == _MISSING:
                    title = f"point {number} of sim-readiness"
                    yield Fix("readiness", _READINESS, title, what, shortened(", ".join(words), _LETTERS))
