"""The head of a build's page: what was built, how it went, its size, and the files."""

from collections.abc import Iterable, Mapping
from typing import Any

from linkwright.pipeline.changes.since import Since
from linkwright.pipeline.page.checks import tally
from linkwright.pipeline.page.figures import NAMES
from linkwright.pipeline.page.files import top_level
from linkwright.pipeline.page.html.template import rendered
from linkwright.stages.robot.text.plural import count

BESIDE = ("report.json", "config.yaml", "build.log")
"""The other documents of a build, in the same folder."""

_MARKS = {"built": "✓", "stale": "!", "invalid": "!", "failed": "✕"}

_FIGURES = ("links", "joints", "dof", "loops", "mass", "parts", "triangles")
"""Figures that the head has."""


def head(tree: Mapping[str, Any], heading: str, changes: Since | None) -> str:
    """The head; `tree`: the report as plain data, `heading`: the robot's name as people know it."""
    status = str(tree["status"])
    seconds = sum(stage["seconds"] for stage in tree["stages"])
    summary = [f"exit status {tree['exit_status']}", f"{seconds:.2f} s", str(tree["folder"])]
    return rendered(
        "head",
        heading=heading,
        status=status,
        mark=_MARKS.get(status, ""),
        summary=", ".join(filter(None, summary)),
        outcome=_outcome(tree, changes),
    )


def facts(tree: Mapping[str, Any], pictures: Iterable[str]) -> str:
    """The robot's size, and links to the files, of which the `pictures` of the robot are no outputs."""
    paths = [*top_level(tree["outputs"]), *pictures, *BESIDE]
    found = {name: tree["figures"][name] for name in _FIGURES if tree["figures"].get(name)}
    figures = [(_word(name, value), _figure(value)) for name, value in found.items()]
    return rendered("facts", figures=figures, paths=paths)


def _outcome(tree: Mapping[str, Any], changes: Since | None) -> list[tuple[str, str]]:
    """How the checks went, what the diagnostics are, and what is different: where each leads, and words."""
    checks = tree["checks"]
    said = []
    if checks:
        said.append(("checks", tally(checks, " checks")))
    codes = [one["code"][:1] for one in tree["diagnostics"]]
    for letter, word in (("E", "error"), ("W", "warning")):
        if letter in codes:
            said.append(("diagnostics", count(codes.count(letter), word)))
    if changes is not None and not changes.first:
        said.append(("changes", difference(changes)))
    return said


def difference(changes: Since) -> str:
    """How much is different from the last build, in words."""
    if changes.nothing:
        return "unchanged since the previous build"
    if changes.unknown:
        return "the previous build cannot be compared"
    number = len(changes.robot) + changes.more
    return f"{count(number, 'difference')} from the previous build" if number else "some files are different"


def _word(name: str, value: float) -> str:
    found = NAMES[name]
    return found.unit or (found.one if value == 1 else found.several)


def _figure(value: float) -> str:
    return f"{value:.4g}" if isinstance(value, float) else f"{value:,}"
