"""Prints the closing text of a build: diagnostics, failed checks, API calls and the output folder."""

import re
import sys
from collections.abc import Iterator
from typing import TextIO

from linkwright.pipeline.options import Detail
from linkwright.pipeline.report import Report, spent
from linkwright.pipeline.terminal.check_text import check_lines, tally
from linkwright.pipeline.terminal.finding_lines import Style, finding_lines
from linkwright.pipeline.terminal.output import clean, width_of
from linkwright.pipeline.terminal.wrapping import wrapped
from linkwright.stages.robot.text.printable import printable

MAX_FINDINGS = 3
"""Largest number of findings of a check that the terminal shows."""

ASCII_REPLACEMENTS = str.maketrans("─│├└…→×≤≥−", "-||`~>*<>-")
"""ASCII replacements of the characters that a stream's encoding may lack."""

_STYLES = {"FAILED": "bold red", "WARNING": "yellow", "E": "bold red", "W": "yellow", "I": "cyan"}
"""Style of a line's first word: by the word, or by the level (E, W, I) of a code."""

FULL_STYLE = Style("", whole=True)

_HEAD = re.compile(r"(FAILED|WARNING|(?P<level>[EWI])-[A-Z0-9-]+)(?= )")


def closing_lines(report: Report, detail: Detail = "usual") -> list[str]:
    """Returns the lines of the closing text. An entry with a text to paste contains line breaks."""
    if detail == "errors":
        return _error_lines(report)
    pages = f" (report.html, {report.preview})" if report.preview else ""
    return [
        *finding_lines(report.diagnostics, _style(report, detail)),
        *_checks(report, detail),
        *_tables(report),
        *_objective(report),
        *([tally(report.checks)] if report.checks else []),
        *spent(report),
        printable(f"{report.heading}: {report.folder or 'in memory'}{pages}"),
        *([printable(report.advice)] if report.advice else []),
    ]


def _error_lines(report: Report) -> list[str]:
    """Returns the lines about errors only: failed checks, and for a stale result its serious diagnostics."""
    diagnostics = report.diagnostics if report.status == "stale" else ()
    serious = [diagnostic for diagnostic in diagnostics if diagnostic.level != "info"]
    return [*finding_lines(serious, FULL_STYLE), *_checks(report, "errors")]


def _style(report: Report, detail: Detail) -> Style:
    return FULL_STYLE if detail == "all" else Style("report.html" if report.folder else "-v shows all")


def _checks(report: Report, detail: Detail) -> Iterator[str]:
    """Yields the checks that did not pass, failed checks last."""
    max_findings = sys.maxsize if detail == "all" else MAX_FINDINGS
    if detail != "errors":
        for check in report.warned_checks:
            yield from check_lines("WARNING", check, max_findings, " in report.json")
    for check in report.failed_checks:
        yield from check_lines("FAILED", check, max_findings, " in report.json")


def _objective(report: Report) -> Iterator[str]:
    if report.objective:
        values = (f"{name} {value:.6g}" for name, value in report.objective.items())
        yield printable(f"objective: {', '.join(values)}")


def _tables(report: Report) -> Iterator[str]:
    location = " (report.html has the table)" if report.folder else ""
    for check in report.checks:
        if check.table and check.passed:
            yield printable(f"{check.name}: {check.detail}{location}")


def render(report: Report, detail: Detail = "usual") -> str:
    """Returns the closing text, after the kinematic tree if the build ended at the graph stage."""
    tree = [*report.outline, ""] if _shows_tree(report, detail) else []
    return "".join(f"{line}\n" for line in [*tree, *closing_lines(report, detail)])


def _shows_tree(report: Report, detail: Detail) -> bool:
    return detail != "errors" and report.until == "graph" and bool(report.outline)


def show(report: Report, stream: TextIO, detail: Detail = "usual") -> None:
    """Prints the closing text: in colour and wrapped on a terminal, else as plain text."""
    output, width = clean(stream), width_of(stream)
    if width is None:
        output.write(encodable(render(report, detail), stream.encoding))
        return
    # Late: Rich takes a while to import, and plain output does not need it.
    from rich.console import Console
    from rich.text import Text

    console = Console(file=output.raw, width=width)
    if _shows_tree(report, detail):
        fits = all(len(line) <= width for line in report.outline)
        for line in (*(report.outline if fits else report.narrow_outline), ""):
            console.print(Text(encodable(output.clean(line), stream.encoding)), soft_wrap=True)
    for line in closing_lines(report, detail):
        # As Text, since brackets in CAD names are not markup.
        text = Text(encodable(wrapped(output.clean(line), width), stream.encoding))
        if head := _HEAD.match(line):
            text.stylize(_STYLES[head["level"] or head[1]], 0, head.end())
        console.print(text, soft_wrap=True)


def encodable(text: str, encoding: str | None) -> str:
    """Replaces the characters that a stream of this encoding cannot write."""
    code = encoding or "utf-8"
    try:
        text.encode(code)
    except UnicodeEncodeError:
        return text.translate(ASCII_REPLACEMENTS).encode(code, "replace").decode(code)
    return text
