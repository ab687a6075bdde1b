"""summary.html: the jobs of a sweep for people, in a table and in plots."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import PurePosixPath
from typing import Any
from urllib.parse import quote

from markupsafe import Markup

from linkwright.pipeline.page.figures import counted, name_of, said, shown
from linkwright.pipeline.page.hero import with_view
from linkwright.pipeline.page.html.shell import ReportSection, Top, document
from linkwright.pipeline.page.html.tables import table
from linkwright.pipeline.page.html.template import marked, name, rendered, shortened
from linkwright.pipeline.page.sweep.axis import numbers
from linkwright.pipeline.page.sweep.plot import SERIES, Dot, mark, plot
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

MOST_PLOTS = 24
"""So many plots are drawn."""

_SAID = 12
"""So many dots of a plot are said to those who do not see it."""

_LETTERS = 300
"""So long is what is said of a job that failed."""

_STATUS = {0: ("built", "✓ built"), 3: ("invalid", "! built")}
_FAILED = ("failed", "✕ failed")

Exists = Callable[[str], bool]
"""Whether there is a file at a path from the folder of the sweep."""


def page(title: str, jobs: Sequence[Job], exists: Exists, beside: Sequence[str]) -> bytes:
    """The page. `jobs`: their outcomes as plain data, their folders from the folder of the sweep, secrets
    blanked; `exists`: which of the files of jobs are there; `beside`: the other files of the sweep."""
    swept = keys(jobs)
    differing, same = varying(jobs)
    parts = [
        ReportSection("jobs", "Jobs", _jobs(jobs, swept, differing, exists)),
        ReportSection("plots", "Plots", _plots(jobs, swept, differing)),
        ReportSection("same", "In common", _same(same)),
    ]
    top = Top(_head(title, jobs, swept), facts=rendered("facts", figures=(), paths=beside))
    return with_view(document(f"{title}: {count(len(jobs), 'job')}", top, parts))


def _head(title: str, jobs: Sequence[Job], swept: Sequence[str]) -> str:
    good = sum(job["status"] == 0 for job in jobs)
    unmet = sum(job["status"] == 3 for job in jobs)
    words = [f"{good} of {count(len(jobs), 'job')} built and valid"]
    words += [f"{unmet} with a check that failed, or not of the newest state"] if unmet else []
    words += [f"{len(jobs) - good - unmet} failed"] if good + unmet < len(jobs) else []
    return rendered("sweep_head", title=title, words=", ".join(words), over=", ".join(swept))


def _jobs(jobs: Sequence[Job], swept: Sequence[str], differing: Sequence[str], exists: Exists) -> str:
    """A row for each job."""
    columns = {f"figure {key}": name_of(key) for key in differing if not key.startswith("checks_")}
    header = ["job", "picture", "status", *swept, *columns.values(), "checks", "calls", "open"]
    rows = []
    for job in jobs:
        figures = {f"figure {key}": shown(value) for key, value in figures_of(job).items()}
        rows.append(
            [
                str(job["number"]),
                _picture(job, exists),
                _status(job),
                *(name(value_of(job, key)) for key in swept),
                *(figures.get(key, "") for key in columns),
                _checks(job["checks"]),
                job["calls"].get("made"),
                _links(job, exists),
            ]
        )
    classes = dict.fromkeys(columns.values(), "number") | {"calls": "number", "job": "job"}
    classes["status"] = "said"
    classes |= {key: "number" for key in swept if not places(key, jobs)[0].discrete}
    return rendered("jobs", table=table(header, rows, classes, heads="job"))


def _status(job: Job) -> Markup:
    style, words = _STATUS.get(job["status"], _FAILED)
    lines = [] if job["message"] == "valid" else [job["message"], *job["problems"]]
    said = Markup("").join(marked("hint", shortened(line, _LETTERS)) for line in lines)
    return marked(f"{style} word", words) + said


def _checks(checks: Mapping[str, Any]) -> str:
    """How many passed, and the names of those that did not."""
    if not checks:
        return ""
    failed, warned = checks["failed"], checks["warned"]
    passed = f"{checks['passed']} of {checks['passed'] + len(failed) + len(warned)} passed"
    unmet = [("failed", f"✕ {one}") for one in failed] + [("warning", f"! {one}") for one in warned]
    return rendered("job_checks", passed=passed, unmet=unmet)


def _picture(job: Job, exists: Exists) -> str:
    path = str(PurePosixPath(job["folder"], "preview.png"))
    return rendered("thumbnail", path=path, number=job["number"]) if exists(path) else ""


def _links(job: Job, exists: Exists) -> Markup:
    report = str(PurePosixPath(job["folder"], "report.html"))
    found = [("report", report, report), ("folder", job["folder"], f"{job['folder']}/")]
    form = Markup('<a href="{}" aria-label="{} of job {}">{}</a>')
    return Markup(" ").join(
        form.format(quote(target), word, job["number"], word) for word, path, target in found if exists(path)
    )


def _same(same: Mapping[str, float]) -> str:
    """The figures that all jobs have in common, in a line."""
    words = ", ".join(counted(key, value) for key, value in same.items())
    return rendered("same", words=words) if words else ""


def _plots(jobs: Sequence[Job], swept: Sequence[str], differing: Sequence[str]) -> str:
    """Each figure that differs against each key that it depends on."""
    built = [job for job in jobs if figures_of(job)]
    # Jobs that failed have no figures, so a key may have one value among the others.
    swept = [key for key in swept if len({value_of(job, key) for job in built}) > 1]
    pairs = [(figure, key) for figure in differing for key in swept]
    if len(built) < 2 or not pairs:
        return ""
    drawn = [pair for pair in pairs if depends(built, *pair, swept)]
    words = [f"without {count(len(jobs) - len(built), 'job')} that failed"] if len(built) < len(jobs) else []
    for key in swept:
        same = [said(figure) for figure in differing if (figure, key) not in drawn]
        words += [f"{', '.join(same)} not changed by {key}"] if same else []
    if len(drawn) > MOST_PLOTS:
        words.append(f"{count(len(drawn) - MOST_PLOTS, 'more plot')}: summary.json has the figures")
    plots = [_plot(built, figure, key, swept) for figure, key in drawn[:MOST_PLOTS]]
    return rendered("plots", plots=plots, lines=words)


def _plot(jobs: Sequence[Job], figure: str, key: str, swept: Sequence[str]) -> dict[str, Any]:
    """A figure against a key; jobs whose other keys have the same values are a series, if these matter."""
    others = [one for one in swept if one != key and depends(jobs, figure, one, swept)]
    rows = [(job, figures_of(job)[figure]) for job in jobs if figure in figures_of(job)]
    axis, at = places(key, [job for job, _ in rows])
    kinds = [values_of(job, others) for job, _ in rows]
    series = list(dict.fromkeys(kinds))
    apart = len(series) <= SERIES
    dots = [
        Dot(x, float(y), f"{job['label']}: {shown(y)}", series.index(kind) if apart else 0)
        for x, (job, y), kind in zip(at, rows, kinds, strict=True)
    ]
    words = f"{name_of(figure)} by {key}: " + "; ".join(dot.words for dot in dots[:_SAID])
    words += f" and {len(dots) - _SAID} more" if len(dots) > _SAID else ""
    y = numbers(name_of(figure), [dot.y for dot in dots])
    drawn = plot(words, axis, y, dots, joined=apart and not axis.discrete)
    legend = _legend(others, series) if apart and len(series) > 1 else []
    return {"title": name_of(figure), "drawn": drawn, "legend": legend}


def _legend(keys: Sequence[str], series: Sequence[Sequence[str]]) -> list[tuple[str, str]]:
    """The form of each series, and what it is."""
    return [
        (mark(number), ", ".join(f"{key} {value}" for key, value in zip(keys, values, strict=True)))
        for number, values in enumerate(series)
    ]
