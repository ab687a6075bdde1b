"""Renders the head of a build's page: what was built, how it went, its size, and the files."""

from collections.abc import Iterable, Mapping
from typing import Any

from linkwright.pipeline.changes.build_changes import BuildChanges
from linkwright.pipeline.page.checks import tally
from linkwright.pipeline.page.figures import NAMES
from linkwright.pipeline.page.files import top_level
from linkwright.pipeline.page.html.template import rendered
from linkwright.stages.robot.text.plural import count

DOCUMENTS = ("report.json", "config.yaml", "build.log")
"""The other documents of a build, in the same folder."""

_MARKS = {"built": "✓", "stale": "!", "invalid": "!", "failed": "✕"}

_FIGURES = ("links", "joints", "dof", "loops", "mass", "parts", "triangles")
"""The figures that the head shows, in this order."""


def head(tree: Mapping[str, Any], heading: str, changes: BuildChanges | None) -> str:
    """Renders the head. `tree`: the report as plain data, `heading`: the robot's name as people know it."""
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
    """Renders the robot's figures, and links to the files. `pictures`: files of the robot's picture, which
    are not among the outputs."""
    paths = [*top_level(tree["outputs"]), *pictures, *DOCUMENTS]
    values = {name: tree["figures"][name] for name in _FIGURES if tree["figures"].get(name)}
    figures = [(_word(name, value), _figure(value)) for name, value in values.items()]
    return rendered("facts", figures=figures, paths=paths)


def _outcome(tree: Mapping[str, Any], changes: BuildChanges | None) -> list[tuple[str, str]]:
    """Returns pairs on checks, diagnostics and differences: the section, and a summary in words."""
    checks = tree["checks"]
    summaries = []
    if checks:
        summaries.append(("checks", tally(checks, " checks")))
    codes = [problem["code"][:1] for problem in tree["diagnostics"]]
    for letter, word in (("E", "error"), ("W", "warning")):
        if letter in codes:
            summaries.append(("diagnostics", count(codes.count(letter), word)))
    if changes is not None and not changes.first:
        summaries.append(("changes", difference(changes)))
    return summaries


def difference(changes: BuildChanges) -> str:
    """Returns in words how much differs from the previous build."""
    if changes.unchanged:
        return "unchanged since the previous build"
    if changes.failure:
        return "the previous build cannot be compared"
    number = len(changes.robot) + changes.more
    return f"{count(number, 'difference')} from the previous build" if number else "some files are different"


def _word(name: str, value: float) -> str:
    figure = NAMES[name]
    return figure.unit or (figure.singular if value == 1 else figure.plural)


def _figure(value: float) -> str:
    return f"{value:.4g}" if isinstance(value, float) else f"{value:,}"
