"""The closing table: it fits a terminal, and says what it leaves out."""

import re
from pathlib import Path

import pytest

from linkwright.pipeline.sweep.outcome import Outcome
from linkwright.pipeline.sweep.terminal_table import MAX_ROWS, table
from linkwright.stages.robot.text.printable import columns

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


def test_nothing_is_shortened_where_there_is_room_or_no_terminal():
    jobs = [outcome(n) for n in range(3)]
    assert table(jobs, ROOT) == table(jobs, ROOT, 300)
    assert "…" not in table(jobs, ROOT)


def test_of_many_jobs_those_that_failed_come_first_and_the_rest_is_counted():
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


def test_a_job_that_runs_has_no_status():
    line = table([outcome(0, None, "running")], ROOT).splitlines()[1]
    assert re.split(r"\s{2,}", line)[:3] == ["0", "running", "vars.upper_arm_length=0.0 mesh=hull"]
