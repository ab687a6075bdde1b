"""What a check found beside what it does not accept is in the report, and a score in the terminal."""

import json

import pytest

from linkwright.pipeline.page.document import page
from linkwright.pipeline.report import Report
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.terminal.closing import closing_lines
from linkwright.stages.robot import codec
from linkwright.stages.robot.check import Check, Table
from tests.support.page_reader import Reader

SCORE = Check(
    "arm.xml: sim-readiness", True, "30 of 33 points", 30.0, 33.0, "C-READINESS", "warning",
    table=Table(("point", "what", ""), ((1, "loads <everywhere>", "passed"), (2, "a scene", None))),
)  # fmt: skip
BARE = Check("arm.xml: compiles", True, "fine")


def report(*checks):
    return Report(status="built", name="arm", folder="out", until="validate", exit_status=0, checks=checks)


def html(*checks):
    return page(report(*checks), {}, {}, Secrets({}))


def test_a_table_comes_through_the_cache_to_page_report_and_terminal():
    assert codec.decode_checks(codec.encode_checks((SCORE,))) == (SCORE,)
    shown = html(SCORE).decode()
    assert "sim-readiness: 30 of 33 points" in shown
    assert "loads &lt;everywhere&gt;" in shown
    assert ">None<" not in shown
    tree = json.loads(report(SCORE).to_json())
    assert tree["checks"][0]["table"]["rows"][0] == [1, "loads <everywhere>", "passed"]
    line = "arm.xml: sim-readiness: 30 of 33 points (report.html has the table)"
    assert closing_lines(report(SCORE)).count(line) == 1


def test_a_check_without_a_table_has_none_on_the_page_and_in_the_terminal():
    assert not [line for line in closing_lines(report(BARE)) if "compiles" in line]
    assert b"compiles: fine" not in html(BARE)


@pytest.mark.parametrize(("levels", "said"), [
    ((), "1 of 1{} passed"),
    (("warning",), "1 of 2{} passed, 1 warns"),
    (("warning", "warning", "error"), "1 of 4{} passed, 1 failed, 2 warn"),
])  # fmt: skip
def test_head_and_section_count_the_checks_that_did_not_pass(levels, said):
    unmet = [
        Check(f"arm.xml: c{n}", False, "no", code="C-REST", level=level) for n, level in enumerate(levels)
    ]
    assert not Reader(html(BARE, *unmet)).lacking(said.format(" checks"), f"Checks: {said.format('')}")
