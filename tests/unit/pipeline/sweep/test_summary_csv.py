"""summary.csv: read back by the standard library's reader, it has what the jobs have, and runs no formula."""

import csv
import io
import json
import math

from hypothesis import given
from hypothesis import strategies as st

from linkwright.pipeline.sweep.summary_csv import csv_content
from linkwright.stages.robot.text.printable import printable_lines
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
def test_no_cell_is_a_formula_and_each_line_ends_as_the_standard_says(jobs):
    data = csv_content(jobs).decode()
    for row in csv.reader(io.StringIO(data, newline=""), strict=True):
        for cell in row:
            if cell.strip()[:1] in tuple("=+-@＝＋－＠"):
                assert math.isfinite(float(cell.replace(",", "x"))), cell
    assert data.endswith("\r\n")


def test_the_columns_are_those_of_the_documents_and_the_same_again():
    titles = csv_content(GRID).decode().splitlines()[0]
    assert titles == (
        "number,label,state,status,message,folder,key.mesh,key.tolerance,figure.links,figure.mass,"
        "objective,checks_passed,checks_failed,checks_warned,calls_made,calls_saved"
    )
    assert csv_content(GRID) == csv_content([dict(job) for job in GRID])
    first = csv_content(GRID).decode().splitlines()[1]
    assert first == "0,mesh=hull tolerance=0.001,built,0,valid,job 0,hull,0.001,11,1.0,,3,0,1,0,5"


def test_a_job_that_did_not_end_has_a_row():
    jobs = [job(0, root="a"), {**job(1, None, {}, "running", root="b"), "checks": {}, "calls": {}}]
    assert csv_content(jobs).decode().splitlines()[2] == "1,root=b,running,,running,job 1,b,,,,,,,,"
