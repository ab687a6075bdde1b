"""The summaries of a sweep: summary.csv, which the standard library reads back, and the closing table."""

import csv
import io
import json
import math
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from linkwright.pipeline.sweep import summary_json
from linkwright.pipeline.sweep.outcome import Outcome
from linkwright.pipeline.sweep.summary_csv import csv_content
from linkwright.pipeline.sweep.terminal_table import MAX_ROWS, table
from linkwright.stages.robot.text.printable import columns, printable_lines
from tests.unit.pipeline.page.test_sweep_page import GRID, job

TEXTS = st.text(st.characters(exclude_categories=["Cs"])) | st.sampled_from(
    ["=1+1", "+1", "-1", "@SUM(A1)", "'", "'=1", " =1", "\t=1", "\n=1", '"', 'a,"b"\r\nc', "＝1", "1", ""]
)
NUMBERS = st.integers() | st.floats(allow_nan=False, allow_infinity=False)
VALUES = TEXTS | NUMBERS | st.booleans() | st.none() | st.lists(NUMBERS)
FIGURES = st.dictionaries(st.sampled_from(["mass", "links", "tip reach", "=x"]), NUMBERS)


@st.composite
def sweeps(draw):
    keys = draw(st.lists(TEXTS, unique=True, min_size=1, max_size=3))
    jobs = []
    for number in range(draw(st.integers(1, 5))):
        overrides = {key: draw(VALUES) for key in keys}
        made = job(number, draw(st.sampled_from([0, 1, 3, None])), draw(FIGURES), draw(TEXTS))
        jobs.append({**made, "label": draw(TEXTS), "overrides": overrides, "objective": draw(NUMBERS)})
    return jobs


def read(data):
    """The rows, with the texts as they were: without the apostrophe in front."""
    rows = csv.reader(io.StringIO(data.decode(), newline=""), strict=True)
    titles, *values = [[cell[1:] if cell[:1] == "'" else cell for cell in row] for row in rows]
    return [dict(zip(titles, row, strict=True)) for row in values]


def meant(value):
    """What a cell means."""
    if value is None:
        return ""
    return printable_lines(value) if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


@given(sweeps())
def test_what_is_read_back_is_what_was_written(jobs):
    rows = read(csv_content(jobs))
    assert len(rows) == len(jobs)
    for row, entry in zip(rows, jobs, strict=True):
        assert row["number"] == str(entry["number"])
        assert (row["label"], row["message"]) == (meant(entry["label"]), meant(entry["message"]))
        assert row["status"] == meant(entry["status"])
        assert json.loads(row["objective"]) == entry["objective"]
        for name in {"mass", "links", "tip reach", "=x"} & entry["figures"].keys():
            assert json.loads(row[f"figure.{name}"]) == entry["figures"][name]
        for key, value in entry["overrides"].items():
            if f"key.{printable_lines(key)}" in row:
                assert row[f"key.{printable_lines(key)}"] == meant(value)


@given(sweeps())
def test_cells_are_no_formulas_and_lines_end_as_standard(jobs):
    data = csv_content(jobs).decode()
    for row in csv.reader(io.StringIO(data, newline=""), strict=True):
        for cell in row:
            if cell.strip()[:1] in tuple("=+-@＝＋－＠"):
                assert math.isfinite(float(cell.replace(",", "x"))), cell
    assert data.endswith("\r\n")


def test_columns_are_those_of_the_documents():
    titles = csv_content(GRID).decode().splitlines()[0]
    assert titles == (
        "number,label,state,status,message,folder,key.mesh,key.tolerance,figure.links,figure.mass,"
        "objective,checks_passed,checks_failed,checks_warned,calls_made,calls_saved"
    )
    assert csv_content(GRID) == csv_content([dict(job) for job in GRID])
    first = csv_content(GRID).decode().splitlines()[1]
    assert first == "0,mesh=hull tolerance=0.001,built,0,valid,job 0,hull,0.001,11,1.0,,3,0,1,0,5"


ROOT = Path("outputs/arm.sweep")


def outcome(number, status=0, message="valid", **more):
    label = f"vars.upper_arm_length=0.{number} mesh=hull"
    figures = {"mass": 3.2, "dof": 7.0} if status in (0, 3) else {}
    return Outcome(
        number, label, status, message, f"{ROOT}/{label}-12345678", {}, figures, calls={"made": 1}, **more
    )


def rows(text):
    return [int(match[1]) for line in text.splitlines() if (match := re.match(r"(\d+)  ", line))]


@pytest.mark.parametrize("width", [20, 40, 72, 80, 120, 200])
def test_it_fits_the_terminal(width):
    jobs = [outcome(n, n % 2, f"ein Löffel 腕 ist zu groß {n} " * 5) for n in range(12)]
    text = table(jobs, ROOT, width)
    *lines, last = text.splitlines()
    assert max(map(columns, lines)) <= width
    assert rows(text) == list(range(12))
    assert last == f"6 of 12 jobs built and valid: {ROOT}"
    if width <= 120:
        assert "…" in lines[1]


def test_table_is_whole_where_there_is_room_or_no_terminal():
    jobs = [outcome(n) for n in range(3)]
    assert table(jobs, ROOT) == table(jobs, ROOT, 300)
    assert "…" not in table(jobs, ROOT)


def test_jobs_that_failed_come_first_of_many():
    jobs = [outcome(n) for n in range(10_000)]
    for n in (17, 4711):
        jobs[n] = outcome(n, 1, "no triangles")
    jobs[99] = outcome(99, 3, "a check failed")
    for n in range(5000, 5100):
        jobs[n] = outcome(n, None, "missing")
    shown = rows(text := table(jobs, ROOT, 100))
    assert len(shown) == MAX_ROWS
    assert shown[:3] == [17, 4711, 99]
    sample = [number for number in shown if number not in (17, 4711, 99) and not 5000 <= number < 5100]
    assert len(sample) >= 15
    assert sample[0] < 1000
    assert sample[-1] > 9000
    left_out, missing = 10_000 - MAX_ROWS, 100 - sum(5000 <= number < 5100 for number in shown)
    counts = f"({missing} missing, {left_out - missing} built)"
    assert f"and {left_out} more jobs {counts}: {ROOT}/summary.csv" in text
    assert len(text.splitlines()) == MAX_ROWS + 3
    # More failures than rows are a sample of failures.
    shown = rows(text := table([outcome(n, 1, "no triangles") for n in range(200)], ROOT))
    assert (len(shown), shown[0], shown[-1]) == (MAX_ROWS, 0, 195)
    assert "and 160 more jobs (160 failed)" in text


def test_a_job_that_runs_has_a_row_without_a_status():
    jobs = [job(0, root="a"), {**job(1, None, {}, "running", root="b"), "checks": {}, "calls": {}}]
    assert csv_content(jobs).decode().splitlines()[2] == "1,root=b,running,,running,job 1,b,,,,,,,,"
    line = table([outcome(0, None, "running")], ROOT).splitlines()[1]
    assert re.split(r"\s{2,}", line)[:3] == ["0", "running", "vars.upper_arm_length=0.0 mesh=hull"]


def test_summary_that_is_nested_too_deeply_has_no_runs(tmp_path):
    (tmp_path / "summary.json").write_text("[" * 100_000)
    assert summary_json.runs(tmp_path) == []
