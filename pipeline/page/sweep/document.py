"""Renders summary.html: the jobs of a sweep, in a table and in plots."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

from markupsafe import Markup

from linkwright.pipeline.page.figures import figure_text, name_of, sentence_name, value_text
from linkwright.pipeline.page.html.shell import ReportSection, Top, document
from linkwright.pipeline.page.html.tables import table
from linkwright.pipeline.page.html.template import marked, name, rendered, shortened
from linkwright.pipeline.page.live_view import with_view
from linkwright.pipeline.page.sweep.axis import numbers
from linkwright.pipeline.page.sweep.data import (
    FOLDER,
    PREVIEW,
    PREVIEW_FILE,
    REPORT,
    REPORT_FILE,
    block,
    existence_bits,
    passed,
    unmet,
)
from linkwright.pipeline.page.sweep.plot import MAX_SERIES, Dot, mark, plot
from linkwright.pipeline.page.sweep.swept import (
    Job,
    depends,
    figures_of,
    keys,
    places,
    value_of,
    values_of,
    varying,
)
from linkwright.stages.robot.text.plural import count
from linkwright.stages.show.live.viewer import ROOM as VIEWER

ROOM = Path(__file__).parent

SCRIPTS = (
    "jobs", "pareto", "selection", "axis", "canvas", "scatter", "parallel", "card", "table", "dots",
    "controls", "start",
)  # fmt: skip
"""The files of the script, in their order, after the viewer's function that makes elements."""

MAX_ROWS = MAX_DRAWN = 300
"""Largest number of jobs that have a row, and of jobs that are plotted, in a page without its script."""

SUMMARY_FILE = "summary.csv"

MAX_PLOTS = 24
"""Largest number of plots."""

_MAX_DOTS_IN_TEXT = 12
"""Largest number of dots in the text of a plot, for readers who do not see it."""

_MAX_LETTERS = 300
"""Largest number of letters in a line about a job that failed."""

_STATES = {
    "built": ("built", "✓ built"),
    "unmet": ("invalid", "! built"),
    "failed": ("failed", "✕ failed"),
    "running": ("soft", "running"),
    "missing": ("soft", "missing"),
}

Exists = Callable[[str], bool]
"""A function that tells whether there is a file at a path from the folder of the sweep."""


def page(title: str, jobs: Sequence[Job], exists: Exists, beside: Sequence[str]) -> bytes:
    """Renders the page.

    `jobs`: the outcomes of the jobs as plain data, with their `state`, folders relative to the folder of the
    sweep, and blanked secrets; `exists`: tells whether a file of a job exists; `beside`: the other files of
    the sweep.
    """
    swept = keys(jobs)
    differing, common_figures = varying(jobs)
    existing_bits = [existence_bits(job, exists) for job in jobs]
    plots = _plots(jobs, swept, differing) if len(jobs) <= MAX_DRAWN else ""
    parts = [
        ReportSection("compare", "Compare", rendered("compare", alike=_equality_text(jobs, differing))),
        ReportSection("jobs", "Jobs", _jobs(jobs, swept, differing, existing_bits)),
        ReportSection("plots", "Plots", plots),
        ReportSection("same", "In common", _common_figures_line(common_figures)),
    ]
    top = Top(_head(title, jobs, swept), facts=rendered("facts", figures=(), paths=beside))
    html = document(f"{title}: {count(len(jobs), 'job')}", top, parts)
    columns = block(jobs, swept, differing, existing_bits)
    data = f'<script type="application/json" id="sweep-data">{columns}</script>'
    scripts = f'{data}\n<script type="module">\n{_script()}</script>'
    for place, piece in (("style", _style()), ("scripts", scripts)):
        html = html.replace(f"<!-- view: {place} -->", piece, 1)
    return with_view(html)


@cache
def _script() -> str:
    names = (VIEWER / "script" / "make.js", *(ROOM / "script" / f"{name}.js" for name in SCRIPTS))
    return "\n".join(path.read_text(encoding="utf-8") for path in names)


@cache
def _style() -> str:
    return (ROOM / "sweep.css").read_text(encoding="utf-8")


def _head(title: str, jobs: Sequence[Job], swept: Sequence[str]) -> str:
    counts = Counter(job["state"] for job in jobs)
    words = [f"{counts['built']} of {count(len(jobs), 'job')} built and valid"]
    if counts["unmet"]:
        words.append(f"{counts['unmet']} with a check that failed, or not of the newest state")
    words += [f"{counts[state]} {state}" for state in ("failed", "running", "missing") if counts[state]]
    return rendered("sweep_head", title=title, words=", ".join(words), over=", ".join(swept))


def _jobs(
    jobs: Sequence[Job], swept: Sequence[str], differing: Sequence[str], existing_bits: Sequence[int]
) -> str:
    """Renders a table with a row for each job; of a large sweep only the first jobs, the script shows all."""
    columns = {f"figure {key}": name_of(key) for key in differing if not key.startswith("checks_")}
    header = ["job", "picture", "status", *swept, *columns.values(), "objective", "checks", "calls", "open"]
    rows = []
    for job, bits in zip(jobs[:MAX_ROWS], existing_bits, strict=False):
        figures = {f"figure {key}": value_text(value) for key, value in figures_of(job).items()}
        rows.append(
            [
                str(job["number"]),
                _picture(job) if bits & PREVIEW else "",
                _status(job),
                *(name(value_of(job, key)) for key in swept),
                *(figures.get(key, "") for key in columns),
                value_text(job["objective"]) if job["objective"] is not None else "",
                _checks(job["checks"]),
                job["calls"].get("made"),
                _links(job, bits),
            ]
        )
    classes = dict.fromkeys([*columns.values(), "objective", "calls"], "number") | {"job": "job"}
    classes["status"] = "said"
    classes |= {key: "number" for key in swept if not places(key, jobs)[0].discrete}
    more = f"{MAX_ROWS} of {len(jobs)} jobs: {SUMMARY_FILE} has all" if len(jobs) > MAX_ROWS else ""
    return rendered("jobs", table=table(header, rows, classes, heads="job"), more=more)


def _status(job: Job) -> Markup:
    style, words = _STATES[job["state"]]
    lines = [] if job["message"] in ("valid", words) else [job["message"], *job["problems"]]
    reasons = Markup("").join(marked("hint", shortened(line, _MAX_LETTERS)) for line in lines)
    return marked(f"{style} word", words) + reasons


def _checks(checks: Mapping[str, Any]) -> str:
    """Renders the number of checks that passed, and the names of the others."""
    styles = {"✕": "failed", "!": "warning"}
    lines = [(styles[mark], f"{mark} {name}") for mark, name in unmet(checks)]
    return rendered("job_checks", passed=passed(checks), unmet=lines) if checks else ""


def _picture(job: Job) -> str:
    return rendered("thumbnail", path=f"{job['folder']}/{PREVIEW_FILE}", number=job["number"])


def _links(job: Job, bits: int) -> Markup:
    targets = [("report", f"{job['folder']}/{REPORT_FILE}", REPORT), ("folder", f"{job['folder']}/", FOLDER)]
    template = Markup('<a href="{}" aria-label="{} of job {}">{}</a>')
    return Markup(" ").join(
        template.format(quote(target), word, job["number"], word)
        for word, target, bit in targets
        if bits & bit
    )


def _equality_text(jobs: Sequence[Job], differing: Sequence[str]) -> str:
    """Returns a sentence if there is nothing to compare; "" if figures differ."""
    built = [job for job in jobs if figures_of(job)]
    if len(built) < 2 or differing:
        return ""
    return f"All figures are the same in all jobs{' that were built' if len(built) < len(jobs) else ''}."


def _common_figures_line(common_figures: Mapping[str, float]) -> str:
    """Renders a line with the figures that all jobs have in common; "" without any."""
    words = ", ".join(figure_text(key, value) for key, value in common_figures.items())
    return rendered("same", words=words) if words else ""


def _plots(jobs: Sequence[Job], swept: Sequence[str], differing: Sequence[str]) -> str:
    """Renders a plot of each differing figure over each key on which it depends."""
    built = [job for job in jobs if figures_of(job)]
    # Jobs that failed have no figures, so a key may have one value among the others.
    swept = [key for key in swept if len({value_of(job, key) for job in built}) > 1]
    pairs = [(figure, key) for figure in differing for key in swept]
    if len(built) < 2 or not pairs:
        return ""
    drawn_pairs = [pair for pair in pairs if depends(built, *pair, swept)]
    words = [f"without {count(len(jobs) - len(built), 'job')} that failed"] if len(built) < len(jobs) else []
    for key in swept:
        unaffected = [sentence_name(figure) for figure in differing if (figure, key) not in drawn_pairs]
        words += [f"{', '.join(unaffected)} not changed by {key}"] if unaffected else []
    if len(drawn_pairs) > MAX_PLOTS:
        words.append(f"{count(len(drawn_pairs) - MAX_PLOTS, 'more plot')}: summary.json has the figures")
    plots = [_plot(built, figure, key, swept) for figure, key in drawn_pairs[:MAX_PLOTS]]
    return rendered("plots", plots=plots, lines=words)


def _plot(jobs: Sequence[Job], figure: str, key: str, swept: Sequence[str]) -> dict[str, Any]:
    """Returns the values of a plot of a figure over a key. Jobs whose other keys have the same values form a
    series, if the figure depends on these keys."""
    other_keys = [other for other in swept if other != key and depends(jobs, figure, other, swept)]
    rows = [(job, figures_of(job)[figure]) for job in jobs if figure in figures_of(job)]
    axis, positions = places(key, [job for job, _ in rows])
    kinds = [values_of(job, other_keys) for job, _ in rows]
    series = list(dict.fromkeys(kinds))
    are_distinct = len(series) <= MAX_SERIES
    dots = [
        Dot(
            x,
            float(y),
            f"{job['label']}: {value_text(y)}",
            series.index(kind) if are_distinct else 0,
            job["number"],
        )
        for x, (job, y), kind in zip(positions, rows, kinds, strict=True)
    ]
    words = f"{name_of(figure)} by {key}: " + "; ".join(dot.words for dot in dots[:_MAX_DOTS_IN_TEXT])
    words += f" and {len(dots) - _MAX_DOTS_IN_TEXT} more" if len(dots) > _MAX_DOTS_IN_TEXT else ""
    y = numbers(name_of(figure), [dot.y for dot in dots])
    svg = plot(words, axis, y, dots, joined=are_distinct and not axis.discrete)
    legend = _legend(other_keys, series) if are_distinct and len(series) > 1 else []
    return {"title": name_of(figure), "drawn": svg, "legend": legend}


def _legend(keys: Sequence[str], series: Sequence[Sequence[str]]) -> list[tuple[str, str]]:
    """Returns the mark of each series, and its keys with their values."""
    return [
        (mark(number), ", ".join(f"{key} {value}" for key, value in zip(keys, values, strict=True)))
        for number, values in enumerate(series)
    ]
