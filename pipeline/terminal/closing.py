"""Prints the closing text of a build: diagnostics, checks, API calls and the output folder."""

import re
import sys
from collections.abc import Iterator
from typing import TextIO

from linkwright.pipeline.options import Detail
from linkwright.pipeline.report import Report, call_lines
from linkwright.pipeline.terminal.check_text import check_lines, tally
from linkwright.pipeline.terminal.finding_lines import Style, finding_lines
from linkwright.pipeline.terminal.output import clean_stream, terminal_width
from linkwright.pipeline.terminal.wrapping import wrapped
from linkwright.stages.robot.text.printable import printable

MAX_FINDINGS = 3
"""Largest number of findings of a check that the terminal shows."""

ASCII_REPLACEMENTS = str.maketrans("─│├└…→×≤≥−", "-||`~>*<>-")
"""Character that a stream's encoding may lack → its replacement in ASCII."""

_RICH_STYLES = {"FAILED": "bold red", "WARNING": "yellow", "E": "bold red", "W": "yellow", "I": "cyan"}
"""First word of a line, or level (E, W, I) of the code that it is → its style in Rich."""

FULL_STYLE = Style(rest="", whole=True)
"""The style that shows all findings, and shortens no message."""

_FIRST_WORD = re.compile(r"(FAILED|WARNING|(?P<level>[EWI])-[A-Z0-9-]+)(?= )")
"""The first word of a line about a check or a diagnostic."""


def closing_lines(report: Report, detail: Detail = "usual") -> list[str]:
    """Returns the lines of the closing text. A line with a text to paste contains line breaks."""
    if detail == "errors":
        return _error_lines(report)
    pages = f" (report.html, {report.preview})" if report.preview else ""
    return [
        *finding_lines(report.diagnostics, _finding_style(report, detail)),
        *_unmet_check_lines(report, detail),
        *_table_lines(report),
        *_objective_lines(report),
        *([tally(report.checks)] if report.checks else []),
        *call_lines(report),
        printable(f"{report.heading}: {report.folder or 'in memory'}{pages}"),
        *([printable(report.advice)] if report.advice else []),
    ]


def _error_lines(report: Report) -> list[str]:
    """Returns the lines about failed checks, and about errors and warnings if the result is stale."""
    diagnostics = report.diagnostics if report.status == "stale" else ()
    errors_and_warnings = [diagnostic for diagnostic in diagnostics if diagnostic.level != "info"]
    return [*finding_lines(errors_and_warnings, FULL_STYLE), *_unmet_check_lines(report, "errors")]


def _finding_style(report: Report, detail: Detail) -> Style:
    if detail == "all":
        return FULL_STYLE
    return Style(rest="report.html" if report.folder else "-v shows all")


def _unmet_check_lines(report: Report, detail: Detail) -> Iterator[str]:
    """Yields the lines of the checks that did not pass: first warnings, unless only errors are shown; then
    failed checks."""
    max_findings = sys.maxsize if detail == "all" else MAX_FINDINGS
    rest = " in report.json" if report.folder else ""
    if detail != "errors":
        for check in report.warned_checks:
            yield from check_lines("WARNING", check, max_findings, rest)
    for check in report.failed_checks:
        yield from check_lines("FAILED", check, max_findings, rest)


def _objective_lines(report: Report) -> Iterator[str]:
    if report.objective:
        values = (f"{name} {value:.6g}" for name, value in report.objective.items())
        yield printable(f"objective: {', '.join(values)}")


def _table_lines(report: Report) -> Iterator[str]:
    """Yields a line for each check that passed and has a table of its results."""
    location = " (report.html has the table)" if report.folder else ""
    for check in report.checks:
        if check.table and check.passed:
            yield printable(f"{check.name}: {check.detail}{location}")


def closing_text(report: Report, detail: Detail = "usual") -> str:
    """Returns the closing text, after the kinematic tree if the build ended at the graph stage."""
    tree = [*report.outline, ""] if _shows_tree(report, detail) else []
    return "".join(f"{line}\n" for line in [*tree, *closing_lines(report, detail)])


def _shows_tree(report: Report, detail: Detail) -> bool:
    return detail != "errors" and report.until == "graph" and bool(report.outline)


def print_closing_text(report: Report, stream: TextIO, detail: Detail = "usual") -> None:
    """Prints the closing text: in colour and wrapped if `stream` is a terminal, else as plain text."""
    output, width = clean_stream(stream), terminal_width(stream)
    if width is None:
        output.write(replace_unencodable(closing_text(report, detail), stream.encoding))
        return
    # Imported late, since Rich takes long to import and plain output does not need it.
    from rich.console import Console
    from rich.text import Text

    console = Console(file=output.raw, width=width)
    if _shows_tree(report, detail):
        fits = all(len(line) <= width for line in report.outline)
        for line in (*(report.outline if fits else report.narrow_outline), ""):
            console.print(Text(replace_unencodable(output.clean_text(line), stream.encoding)), soft_wrap=True)
    for line in closing_lines(report, detail):
        # A string would be read as markup, and names in CAD may have brackets.
        text = Text(replace_unencodable(wrapped(output.clean_text(line), width), stream.encoding))
        if word := _FIRST_WORD.match(line):
            text.stylize(_RICH_STYLES[word["level"] or word[1]], 0, word.end())
        console.print(text, soft_wrap=True)


def replace_unencodable(text: str, encoding: str | None) -> str:
    """Returns a text with replacements of the characters that a stream of this encoding cannot write. Without
    an encoding it is UTF-8."""
    codec = encoding or "utf-8"
    try:
        text.encode(codec)
    except UnicodeEncodeError:
        return text.translate(ASCII_REPLACEMENTS).encode(codec, "replace").decode(codec)
    return text
