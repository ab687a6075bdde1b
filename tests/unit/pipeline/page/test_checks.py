"""What a check found beside what it does not accept is in the report, and a score in the terminal."""

import json
from pathlib import Path

from pipeline.page.document import page
from pipeline.report import Report, findings
from pipeline.secrets import Secrets
from stages.robot import codec
from stages.robot.check import Check, Table

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
    lines = findings(report(SCORE))
    assert lines.count("arm.xml: sim-readiness: 30 of 33 points") == 1
    bare = Check("arm.xml: compiles", True, "no warnings")
    assert not [line for line in findings(report(bare)) if "compiles" in line]


def test_a_check_without_a_table_has_none_on_the_page():
    html = page(report(Check("arm.xml: compiles", True, "fine")), {}, {}, Secrets({})).decode()
    assert "compiles: fine" not in html
    assert Path("out").name in html
