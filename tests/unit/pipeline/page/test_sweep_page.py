"""summary.html: the jobs of a sweep in a table, and their figures in plots."""

import itertools
import json
import math
import re

import pytest

from linkwright.pipeline.page.sweep.axis import categories, numbers
from linkwright.pipeline.page.sweep.document import MAX_PLOTS, MAX_ROWS, page
from linkwright.pipeline.page.sweep.plot import HEIGHT, WIDTH, Dot, plot
from linkwright.pipeline.page.sweep.swept import depends, keys, places, varying
from linkwright.pipeline.sweep.outcome import state_of
from tests.support.page_reader import Reader

HOSTILE = "</script><img src=x onerror=alert(1)>"


def job(number, status=0, figures=None, message="valid", **overrides):
    checks = {"passed": 3, "warned": ["a.xml: reach"], "failed": [] if status == 0 else ["a.xml: mass"]}
    return {
        "number": number,
        "label": " ".join(f"{key}={value}" for key, value in overrides.items()),
        "status": status,
        "state": state_of(status, message),
        "message": message,
        "folder": f"job {number}",
        "overrides": overrides,
        "figures": {"links": 11, "mass": 1.0 + number / 10} if figures is None else figures,
        "checks": {} if status == 1 else checks,
        "calls": {"made": 0, "saved": 5},
        "problems": ["E-MASS Pin: no mass"] if status == 1 else [],
        "objective": None,
    }


CELLS = itertools.product(("hull", "ladder"), (0.001, 0.002, 0.005))
GRID = [job(number, mesh=mesh, tolerance=tolerance) for number, (mesh, tolerance) in enumerate(CELLS)]


def made(jobs, there=(), beside=("summary.json",)):
    return page("arm.sweep", jobs, there.__contains__, beside)


def plots(html):
    return re.findall(r'<svg class="plot" .*?</svg>', html, re.DOTALL)


def with_figures(*figures):
    """The jobs of the grid with other figures."""
    return [{**job, "figures": row} for job, row in zip(GRID, figures, strict=True)]


def test_row_of_a_job_has_values_figures_checks_and_links():
    jobs = [*GRID[:2], job(2, 3, message="a check failed", mesh="hull", tolerance=0.005)]
    jobs.append(job(3, 1, {}, f"upper_arm: no triangles {HOSTILE}", mesh="none", tolerance=0.001))
    data = made(jobs, {"job 0/report.html", "job 0", "job 0/preview.png", "job 3"})
    read = Reader(data)
    assert b"<img src=x" not in data
    assert not read.lacking(
        "2 of 4 jobs built and valid", "1 with a check that failed", "1 failed", "over mesh, tolerance",
        "✕ a.xml: mass", "! a.xml: reach", "3 of 4 passed", "3 of 5 passed", "1.2", "E-MASS Pin: no mass",
        "11 links",
    )  # fmt: skip
    assert "".join(read.said).count(HOSTILE) == 1
    links = [target for target in read.links if not target.startswith("#")]
    assert links == ["summary.json", "job%200/preview.png", "job%200/report.html", "job%200/", "job%203/"]
    rows = re.findall(r'<tr><th scope="row" class="job">(\d)</th>', data.decode())
    assert rows == ["0", "1", "2", "3"]
    titles = re.findall(r'<th scope="col"[^>]*>(.*?)</th>', data.decode())
    assert len(set(titles)) == len(titles) >= 6, "no two columns have one title"


def test_figure_that_differs_is_plotted_against_each_key():
    html = made(GRID).decode()
    first, second = plots(html)
    assert [plot.count("<title>") for plot in (first, second)] == [6, 6]
    assert "<title>mesh=hull tolerance=0.001: 1</title>" in first
    assert not Reader(html.encode()).lacking("In common", "11 links", "mesh hull", "mesh ladder")
    # A line for each series where numbers are swept, none between categories.
    assert (first.count("<polyline"), second.count("<polyline")) == (0, 2)
    # Series differ in the form of their dots, and the legend names them.
    assert (second.count("<circle"), second.count("<rect")) == (3, 3)
    assert re.findall(r"(?:https?:)?//[a-z0-9.-]+\.[a-z]+/|url\(|@import", html) == []
    assert html == made([dict(job) for job in GRID]).decode()


def test_figure_is_plotted_only_against_keys_that_change_it():
    """Triangles follow the mesh alone, mass the tolerance alone."""
    numbers = [entry["number"] for entry in GRID]
    html = made(with_figures(*({"triangles": 100 * (n // 3), "mass": n % 3} for n in numbers))).decode()
    assert re.findall(r"<figcaption>(.*?)</figcaption>", html) == ["triangles", "mass, kg"]
    lines = ("triangles not changed by tolerance", "mass not changed by mesh")
    assert not Reader(html.encode()).lacking(*lines)
    # What the other key makes no difference to is one series.
    assert 'class="legend"' not in html
    assert html.count("<polyline") == 1
    html = made(with_figures(*({"joints": n // 3, "links": 1 + n // 3} for n in numbers)))
    assert "joints, links not changed by tolerance" in Reader(html).text
    # What no two jobs tell apart may matter.
    diagonal = [job(number, a=number, b=-number) for number in range(3)]
    assert [depends(diagonal, "mass", key, ["a", "b"]) for key in "ab"] == [True, True]
    assert made(diagonal).decode().count('<svg class="plot"') == 2


def test_dots_are_where_their_values_are():
    """The positions of dots are affine in the values, and those of named values are the same."""
    values = [(1.0, 10.0), (2.0, 30.0), (4.0, 20.0)]
    jobs = [job(number, figures={"mass": y}, x=x) for number, (x, y) in enumerate(values)]
    html = made(jobs).decode()
    (drawn,) = plots(html)
    centres = re.findall(r'<circle [^>]*cx="([\d.]+)" cy="([\d.]+)"', drawn)
    (x0, y0), (x1, y1), (x2, y2) = (map(float, centre) for centre in centres)
    assert (x2 - x0) / (x1 - x0) == pytest.approx(3.0, abs=0.01)
    assert (y2 - y0) / (y1 - y0) == pytest.approx(0.5, abs=0.01)
    assert x0 < x1 < x2
    assert y1 < y2 < y0
    ticks = re.findall(r'<text x="([\d.]+)" y="[\d.]+" text-anchor="middle">([\d.]+)</text>', html)
    per = (x1 - x0) / (2.0 - 1.0)
    for at, name in ticks:
        assert float(at) == pytest.approx(x0 + per * (float(name) - 1.0), abs=0.15)
    assert len(ticks) >= 3


@pytest.mark.parametrize(
    "values",
    [[0, 1], [3.286, 3.2861], [-5, 1000], [1e-9, 2e-9], [7, 7], [0, 0], [1e12, 3e12], [0.1, 0.2, 0.35]],
)
def test_named_values_are_round_within_the_axis_and_told_apart(values):
    axis = numbers("x", values)
    assert 2 <= len(axis.ticks) <= 7
    assert len({name for _, name in axis.ticks}) == len(axis.ticks)
    for value, name in axis.ticks:
        assert 0.0 - 1e-9 <= axis.share(value) <= 1.0 + 1e-9
        assert float(name.replace(",", "")) == pytest.approx(
            value, rel=1e-9, abs=1e-12 * max(map(abs, values), default=1)
        )
    assert all(0.0 <= axis.share(value) <= 1.0 for value in values)


def test_values_that_lie_far_apart_stand_by_their_logarithm():
    axis = numbers("x", [0.001, 0.01, 0.1], may_be_log=True)
    low, middle, high = map(axis.share, (0.001, 0.01, 0.1))
    assert middle - low == pytest.approx(high - middle)
    assert [name for _, name in axis.ticks] == ["0.001", "0.01", "0.1"] or len(axis.ticks) >= 3
    assert not numbers("x", [-1, 100], may_be_log=True).log


def test_numbers_with_one_unit_are_numbers():
    lengths = [job(number, leg=leg) for number, leg in enumerate(("0.2 m", "0.25 m", "1e-1 m"))]
    axis, at = places("leg", lengths)
    assert (axis.title, at) == ("leg, m", [0.2, 0.25, 0.1])
    mixed = [job(number, leg=leg) for number, leg in enumerate(("0.2 m", "20 mm", True, None))]
    axis, at = places("leg", mixed)
    assert axis.discrete
    assert [name for _, name in axis.ticks] == ["0.2 m", "20 mm", "true", "null"]
    assert at == [0, 1, 2, 3]


def test_what_is_swept_is_what_differs_and_of_one_job_all():
    assert keys(GRID) == ["mesh", "tolerance"]
    assert keys(GRID[:3]) == ["tolerance"]
    assert keys(GRID[:1]) == ["mesh", "tolerance"]
    assert varying(GRID) == (["mass"], {"links": 11, "checks_failed": 0, "checks_warned": 1})
    failed = job(9, 1, {"links": 3}, mesh="x", tolerance=1)
    assert varying([*GRID, failed])[0] == ["mass"]


def test_plots_need_several_jobs_figures_and_values():
    assert "<svg" not in made(GRID[:1]).decode()
    assert "<svg" not in made([job(0, 1, {}, a=1), job(1, 1, {}, a=2)]).decode()
    assert "without 1 job that failed" in made([*GRID, job(9, 1, {}, mesh="x", tolerance=1)]).decode()
    failed = [job(6 + number, 1, {}, mesh="none", tolerance=at) for number, at in enumerate((0.001, 0.002))]
    html = made([*GRID[:3], *failed]).decode()
    assert len(plots(html)) == 1
    assert "mesh hull" not in Reader(html.encode()).text
    assert "mesh" not in re.findall(r'<text class="title"[^>]*>(.*?)</text>', html)


def test_figures_that_are_all_alike_are_one_line():
    alike = with_figures(*[{"mass": 2.0}] * 6)
    failed = job(6, 1, {}, mesh="none", tolerance=0.001)
    words = "All figures are the same in all jobs"
    assert f"{words}." in Reader(made(alike)).text
    assert f"{words} that were built." in Reader(made([*alike, failed])).text
    for jobs in (GRID, alike[:1], [failed, failed]):
        assert words not in Reader(made(jobs)).text


@pytest.mark.parametrize("values", [[9, 11], [6, 7], [0, 1, 3], [14460, 16136]])
def test_of_whole_numbers_whole_ones_are_named(values):
    assert all(float(value).is_integer() and "." not in name for value, name in numbers("x", values).ticks)


def test_many_figures_and_many_series_stay_readable():
    figures = {f"figure_{number}": float(number) for number in range(40)}
    jobs = [job(n, figures={key: value * n for key, value in figures.items()}, a=n) for n in range(3)]
    html = made(jobs).decode()
    assert html.count('<svg class="plot"') == MAX_PLOTS
    assert "15 more plots" in html
    many = [job(n, a=n % 6, b=f"kind {n}") for n in range(12)]
    assert "<polyline" not in made(many).decode()
    assert 'class="legend"' not in made(many).decode()


def test_nothing_is_drawn_beside_the_plot():
    axis = categories("key " * 40, [f"a category with a long name {number}" for number in range(9)])
    y = numbers("mass", [1e-7, 123456789.0])
    html = plot("words", axis, y, [Dot(0, 1e-7, HOSTILE), Dot(8, 123456789.0, "x")], joined=False)
    assert HOSTILE not in html
    for x, anchor, words in re.findall(r'<text[^>]* x="([\d.]+)"[^>]*text-anchor="(\w+)">(.*?)</text>', html):
        wide = 6.1 * len(words)
        left = float(x) - {"end": wide, "middle": wide / 2}[anchor]
        assert left >= -1, words
        assert left + wide <= WIDTH + 6, words
    for y_at in re.findall(r' y="([\d.]+)"', html):
        assert 0 <= float(y_at) <= HEIGHT
    assert not math.isnan(axis.share(1))


def data_of(html):
    """What the script of the page reads."""
    block = re.search(rb'<script type="application/json" id="sweep-data">(.*?)</script>', html, re.DOTALL)
    return json.loads(block[1])


def test_the_script_has_the_values_of_all_jobs():
    jobs = [*GRID, job(6, 1, {}, f"no triangles {HOSTILE}", mesh="none", tolerance=0.01)]
    jobs.append(
        {**job(7, None, {}, "running", mesh="hull", tolerance=0.1), "checks": {}, "objective": math.inf}
    )
    jobs[2] = {**jobs[2], "objective": -0.25}
    data = data_of(made(jobs, {"job 0", "job 0/preview.png", "job 6"}))
    columns = {column["title"]: column for column in data["columns"]}
    mesh = columns["mesh"]
    assert [mesh["names"][at] for at in mesh["values"]] == [job["overrides"]["mesh"] for job in jobs]
    assert columns["tolerance"]["values"] == [job["overrides"]["tolerance"] for job in jobs]
    assert columns["mass, kg"]["values"] == [1.0, 1.1, 1.2, 1.3, 1.4, 1.5, None, None]
    assert columns["objective"]["values"] == [None, None, -0.25, None, None, None, None, None]
    assert data["states"] == [0] * 6 + [2, 3]
    assert data["texts"][data["messages"][6]] == f"no triangles {HOSTILE}"
    assert data["has"] == [5, 0, 0, 0, 0, 0, 4, 0]


def test_page_of_a_large_sweep_is_a_small_file():
    jobs = [
        job(n, figures={"mass": 1 / (n + 1), "reach": n / 7, "triangles": n}, a=n % 10, b=f"{n // 10} m")
        for n in range(3_000)
    ]
    data = made(jobs, [f"{entry['folder']}{end}" for entry in jobs[:20] for end in ("", "/preview.png")])
    assert len(data) < 1_500_000
    assert f"{MAX_ROWS} of 3000 jobs: summary.csv has all" in Reader(data).text
    assert data.count(b'<th scope="row"') == MAX_ROWS
    assert len(data_of(data)["numbers"]) == 3_000
    assert b'<svg class="plot' not in data
