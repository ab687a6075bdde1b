"""What a check found beside what it does not accept is in the report, and a score in the terminal."""

import json
from pathlib import Path

import pytest

from linkwright.pipeline.page.document import page
from linkwright.pipeline.report import Report
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.terminal.closing import closing_lines
from linkwright.stages.robot import codec
from linkwright.stages.robot.check import Check, Table
from tests.support.page_reader import Reader

SCORE = Check(
    "arm.xml: sim-readiness",
    True,
    "30 of 33 points",
    30.0,
    33.0,
    "C-READINESS",
    "warning",
    table=Table(("point", "what", ""), ((1, "loads <everywhere>", "passed"), (2, "a scene", None))),
)


def report(*checks: Check) -> Report:
    return Report(status="built", name="arm", folder="out", until="validate", exit_status=0, checks=checks)


def test_a_table_comes_through_the_cache():
    assert codec.decode_checks(codec.encode_checks((SCORE,))) == (SCORE,)


def test_the_page_has_the_table():
    html = page(report(SCORE), {}, {}, Secrets({})).decode()
    assert "sim-readiness: 30 of 33 points" in html
    assert "loads &lt;everywhere&gt;" in html
    assert ">None<" not in html


def test_report_json_has_the_table():
    tree = json.loads(report(SCORE).to_json())
    assert tree["checks"][0]["table"]["rows"][0] == [1, "loads <everywhere>", "passed"]


def test_the_terminal_has_one_line_of_it():
    lines = closing_lines(report(SCORE))
    assert lines.count("arm.xml: sim-readiness: 30 of 33 points (report.html has the table)") == 1
    bare = Check("arm.xml: compiles", True, "no warnings")
    assert not [line for line in closing_lines(report(bare)) if "compiles" in line]


@pytest.mark.parametrize(
    ("levels", "said"),
    [
        ((), "1 of 1{} passed"),
        (("warning",), "1 of 2{} passed, 1 warns"),
        (("warning", "warning", "error"), "1 of 4{} passed, 1 failed, 2 warn"),
    ],
)
def test_the_head_and_the_section_say_what_the_checks_did_that_did_not_pass(levels, said):
    unmet = [
        Check(f"arm.xml: c{number}", False, "no", code="C-REST", level=level)
        for number, level in enumerate(levels)
    ]
    text = Reader(page(report(Check("arm.xml: compiles", True, "fine"), *unmet), {}, {}, Secrets({}))).text
    assert said.format(" checks") in text
    assert f"Checks: {said.format('')}" in text


def test_a_check_without_a_table_has_none_on_the_page():
    html = page(report(Check("arm.xml: compiles", True, "fine")), {}, {}, Secrets({})).decode()
    assert "compiles: fine" not in html
    assert Path("out").name in html
