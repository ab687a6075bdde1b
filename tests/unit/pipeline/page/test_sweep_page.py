"""summary.html: the jobs of a sweep in a table, and their figures in plots."""

import math
import re

import pytest

from linkwright.pipeline.page.sweep.axis import categories, numbers
from linkwright.pipeline.page.sweep.document import MOST_PLOTS, page
from linkwright.pipeline.page.sweep.plot import HEIGHT, WIDTH, Dot, plot
from linkwright.pipeline.page.sweep.swept import depends, keys, places, varying
from tests.support.page_reader import Reader

HOSTILE = "</script><img src=x onerror=alert(1)>"


def job(number, status=0, figures=None, message="valid", **overrides):
    checks = {"passed": 3, "warned": ["a.xml: reach"], "failed": [] if status == 0 else ["a.xml: mass"]}
    return {
        "number": number,
        "label": " ".join(f"{key}={value}" for key, value in overrides.items()),
        "status": status,
        "message": message,
        "folder": f"job {number}",
        "overrides": overrides,
        "figures": {"links": 11, "mass": 1.0 + number / 10} if figures is None else figures,
        "checks": {} if status == 1 else checks,
        "calls": {"made": 0, "saved": 5},
        "problems": ["E-MASS Pin: no mass"] if status == 1 else [],
    }


GRID = [
    job(number, mesh=mesh, tolerance=tolerance)
    for number, (mesh, tolerance) in enumerate(
        (m, t) for m in ("hull", "ladder") for t in (0.001, 0.002, 0.005)
    )
]


def made(jobs, there=(), beside=("summary.json",)):
    return page("arm.sweep", jobs, there.__contains__, beside)


def dots(html):
    """The centres of the round dots, and the titles of all dots, plot by plot."""
    plots = re.findall(r'<svg class="plot" .*?</svg>', html, re.DOTALL)
    centres = [
        [(float(x), float(y)) for x, y in re.findall(r'<circle [^>]*cx="([\d.]+)" cy="([\d.]+)"', one)]
        for one in plots
    ]
    return centres, [re.findall(r"<title>(.*?)</title>", one) for one in plots]


def test_a_row_for_each_job_with_its_values_figures_checks_and_links():
    jobs = [*GRID[:2], job(2, 3, message="a check failed", mesh="hull", tolerance=0.005)]
    jobs.append(job(3, 1, {}, f"upper_arm: no triangles {HOSTILE}", mesh="none", tolerance=0.001))
    there = {"job 0/report.html", "job 0", "job 0/preview.png", "job 3"}
    data = made(jobs, there)
    read = Reader(data)
    assert b"<img src=x" not in data
    for words in (
        "2 of 4 jobs built and valid",
        "1 with a check that failed",
        "1 failed",
        "over mesh, tolerance",
    ):
        assert words in read.text
    assert "".join(read.said).count(HOSTILE) == 1
    for words in (
        "✕ a.xml: mass",
        "! a.xml: reach",
        "3 of 4 passed",
        "3 of 5 passed",
        "1.2",
        "E-MASS Pin: no mass",
        "11 links",
    ):
        assert words in read.text, words
    links = [target for target in read.links if not target.startswith("#")]
    assert links == ["summary.json", "job%200/preview.png", "job%200/report.html", "job%200/", "job%203/"]
    rows = re.findall(r'<tr><th scope="row" class="job">(\d)</th>', data.decode())
    assert rows == ["0", "1", "2", "3"]


def test_each_figure_that_differs_is_plotted_against_each_key_and_others_are_named_in_a_line():
    html = made(GRID).decode()
    _, titles = dots(html)
    assert len(titles) == 2
    assert [len(one) for one in titles] == [6, 6]
    assert titles[0][0] == "mesh=hull tolerance=0.001: 1"
    read = Reader(html.encode())
    assert "In common" in read.text
    assert "11 links" in read.text
    # A line for each series where numbers are swept, none between categories.
    first, second = re.findall(r'<svg class="plot" .*?</svg>', html, re.DOTALL)
    assert (first.count("<polyline"), second.count("<polyline")) == (0, 2)
    # Series differ in the form of their dots, and the legend names them.
    assert (second.count("<circle"), second.count("<rect")) == (3, 3)
    assert "mesh hull" in read.text
    assert "mesh ladder" in read.text


def test_a_figure_is_not_plotted_against_a_key_on_which_it_does_not_depend():
    """Triangles follow the mesh alone, mass the tolerance alone."""
    figures = [{"triangles": 100 * (one["number"] // 3), "mass": one["number"] % 3} for one in GRID]
    jobs = [{**one, "figures": row} for one, row in zip(GRID, figures, strict=True)]
    html = made(jobs).decode()
    text = Reader(html.encode()).text
    assert re.findall(r"<figcaption>(.*?)</figcaption>", html) == ["triangles", "mass, kg"]
    assert "triangles not changed by tolerance" in text
    assert "mass not changed by mesh" in text
    # What the other key makes no difference to is one series.
    assert 'class="legend"' not in html
    assert html.count("<polyline") == 1


def test_what_no_two_jobs_tell_apart_may_matter():
    diagonal = [job(number, a=number, b=-number) for number in range(3)]
    assert depends(diagonal, "mass", "a", ["a", "b"])
    assert depends(diagonal, "mass", "b", ["a", "b"])
    assert made(diagonal).decode().count('<svg class="plot"') == 2


def test_dots_are_where_their_values_are():
    """The positions of dots are affine in the values, and those of named values are the same."""
    values = [(1.0, 10.0), (2.0, 30.0), (4.0, 20.0)]
    jobs = [job(number, figures={"mass": y}, x=x) for number, (x, y) in enumerate(values)]
    html = made(jobs).decode()
    (found,), _ = dots(html)
    (x0, y0), (x1, y1), (x2, y2) = found
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


def test_numbers_with_a_unit_are_numbers_and_others_are_categories():
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


def test_one_job_and_no_figure_have_no_plots():
    assert "<svg" not in made(GRID[:1]).decode()
    assert "<svg" not in made([job(0, 1, {}, a=1), job(1, 1, {}, a=2)]).decode()
    assert "without 1 job that failed" in made([*GRID, job(9, 1, {}, mesh="x", tolerance=1)]).decode()


def test_a_key_with_one_value_among_the_jobs_that_were_built_has_no_plot():
    failed = [job(6 + number, 1, {}, mesh="none", tolerance=at) for number, at in enumerate((0.001, 0.002))]
    html = made([*GRID[:3], *failed]).decode()
    assert len(dots(html)[1]) == 1
    assert "mesh hull" not in Reader(html.encode()).text
    assert "mesh" not in re.findall(r'<text class="title"[^>]*>(.*?)</text>', html)


def test_figures_that_a_key_does_not_change_are_in_one_line_of_that_key():
    figures = [{"joints": one["number"] // 3, "links": 1 + one["number"] // 3} for one in GRID]
    html = made([{**one, "figures": row} for one, row in zip(GRID, figures, strict=True)])
    assert "joints, links not changed by tolerance" in Reader(html).text


def test_no_two_columns_have_one_title():
    jobs = [job(number, figures={"links": number}, mesh=number) for number in range(2)]
    titles = re.findall(r'<th scope="col"[^>]*>(.*?)</th>', made(jobs, {"job 0"}).decode())
    assert len(set(titles)) == len(titles) >= 6


@pytest.mark.parametrize("values", [[9, 11], [6, 7], [0, 1, 3], [14460, 16136]])
def test_of_whole_numbers_whole_ones_are_named(values):
    assert all(float(value).is_integer() and "." not in name for value, name in numbers("x", values).ticks)


def test_many_figures_and_many_series_stay_readable():
    figures = {f"figure_{number}": float(number) for number in range(40)}
    jobs = [job(n, figures={key: value * n for key, value in figures.items()}, a=n) for n in range(3)]
    html = made(jobs).decode()
    assert html.count('<svg class="plot"') == MOST_PLOTS
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


def test_the_same_jobs_give_the_same_bytes():
    assert made(GRID) == made([dict(one) for one in GRID])
