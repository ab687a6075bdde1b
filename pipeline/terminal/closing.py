"""The closing text of a build: findings, checks that did not pass, API calls and the output folder."""

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

MOST_FINDINGS = 3
"""Of a check, in the terminal."""

PLAIN = str.maketrans("─│├└…→×≤≥−", "-||`~>*<>-")
"""ASCII replacements of the characters that a stream's encoding may lack."""

_STYLES = {"FAILED": "bold red", "WARNING": "yellow", "E": "bold red", "W": "yellow", "I": "cyan"}
"""The style of the word that a line begins with, by the word or the level of a code."""

_HEAD = re.compile(r"(FAILED|WARNING|(?P<level>[EWI])-[A-Z0-9-]+)(?= )")


def closing_lines(report: Report, detail: Detail = "usual") -> list[str]:
    """One text a line; a text to paste has several lines."""
    lines = [] if detail == "errors" else finding_lines(report.diagnostics, _style(report, detail))
    lines += _checks(report, detail)
    if detail == "errors":
        found = report.diagnostics if report.status == "stale" else ()
        return finding_lines([one for one in found if one.level != "info"], WHOLE) + lines
    pages = f" (report.html, {report.preview})" if report.preview else ""
    return [
        *lines,
        *_tables(report),
        *([tally(report.checks)] if report.checks else []),
        *spent(report),
        printable(f"{report.heading}: {report.folder or 'in memory'}{pages}"),
        *([printable(report.advice)] if report.advice else []),
    ]


WHOLE = Style("", whole=True)


def _style(report: Report, detail: Detail) -> Style:
    return WHOLE if detail == "all" else Style("report.html" if report.folder else "-v shows all")


def _checks(report: Report, detail: Detail) -> Iterator[str]:
    """The checks that did not pass, those that failed last."""
    most = sys.maxsize if detail == "all" else MOST_FINDINGS
    if detail != "errors":
        for check in report.warned_checks:
            yield from check_lines("WARNING", check, most, " in report.json")
    for check in report.failed_checks:
        yield from check_lines("FAILED", check, most, " in report.json")


def _tables(report: Report) -> Iterator[str]:
    where = " (report.html has the table)" if report.folder else ""
    for check in report.checks:
        if check.table and check.passed:
            yield printable(f"{check.name}: {check.detail}{where}")


def render(report: Report, detail: Detail = "usual") -> str:
    """The kinematic tree, of a build that ends at the graph stage, and the closing lines; "" for nothing."""
    tree = [*report.outline, ""] if _shows_tree(report, detail) else []
    return "".join(f"{line}\n" for line in [*tree, *closing_lines(report, detail)])


def _shows_tree(report: Report, detail: Detail) -> bool:
    return detail != "errors" and report.until == "graph" and bool(report.outline)


def show(report: Report, stream: TextIO, detail: Detail = "usual") -> None:
    """Prints the closing text: in colour and wrapped on a terminal, else as plain text."""
    out, width = clean(stream), width_of(stream)
    if width is None:
        out.write(fitting(render(report, detail), stream.encoding))
        return
    # Late: Rich takes a while to import, and plain output needs none of it.
    from rich.console import Console
    from rich.text import Text

    console = Console(file=out.raw, width=width)
    if _shows_tree(report, detail):
        fits = all(len(line) <= width for line in report.outline)
        for line in (*(report.outline if fits else report.narrow_outline), ""):
            console.print(Text(fitting(out.clean(line), stream.encoding)), soft_wrap=True)
    for line in closing_lines(report, detail):
        # As Text, since brackets in CAD names are not markup.
        text = Text(fitting(wrapped(out.clean(line), width), stream.encoding))
        if head := _HEAD.match(line):
            text.stylize(_STYLES[head["level"] or head[1]], 0, head.end())
        console.print(text, soft_wrap=True)


def fitting(text: str, encoding: str | None) -> str:
    """`text` with characters that a stream of this encoding can write."""
    code = encoding or "utf-8"
    try:
        text.encode(code)
    except UnicodeEncodeError:
        return text.translate(PLAIN).encode(code, "replace").decode(code)
    return text
