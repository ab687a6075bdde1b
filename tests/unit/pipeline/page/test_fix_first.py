"""What to fix first: the gravest, each kind once, with what to do and where it is explained."""

from dataclasses import replace

from linkwright.pipeline.page.fix_first import fix_first, fixes
from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.robot.check import Check, Finding, Table
from linkwright.stages.robot.errors import Diagnostic
from tests.support.page_reader import Reader
from tests.unit.pipeline.page.test_document import REPORT

LIMITS = tuple(Diagnostic("W-LIMIT", f"no limits {i}", f"Arm/Joint {i}", "set them") for i in range(7))
ERROR = Diagnostic("E-MASS", "no mass", "Pin")
POINTS = Table(
    ("point", "what a model should have", "", "what would raise it"),
    ((1, "loads", "passed", ""), (2, "few pieces", "missing", "coarser"), (3, "rests", "missing", "x")),
)
READINESS = Check("arm.xml: sim-readiness", True, "1 of 3", code="C-READINESS", level="warning", table=POINTS)
MASS = tuple(Check(f"{file}: mass", False, "1 kg <off>", 1.0, 0.0, "C-MASS") for file in ("a.xml", "a.urdf"))
HIT = (Finding("joint", "range", "hit"),)
REACH = Check("a.xml: reach", False, "2", code="C-REACH", level="warning", findings=HIT)


def tree(**more):
    return replace(REPORT, **{"diagnostics": (), "checks": (), **more}).tree()


def section(**more):
    return Reader(fix_first(tree(**more), fixes(tree(**more))).replace("#", "file:").encode())


def test_the_gravest_are_first_and_those_of_a_kind_are_one():
    diagnostics = (Diagnostic("I-FYI", "as asked"), *LIMITS, ERROR)
    rows = fixes(tree(diagnostics=diagnostics, checks=(READINESS, REACH, *MASS)))
    assert [(fix.rank, fix.code, fix.count) for fix in rows] == [
        ("error", "E-MASS", 1), ("failed", "C-MASS", 1), ("warning", "W-LIMIT", 7), ("warning", "C-REACH", 1),
        ("readiness", "C-READINESS", 1), ("readiness", "C-READINESS", 1),
    ]  # fmt: skip
    assert rows[1].title == "mass in a.xml, a.urdf"
    assert [(fix.finding, fix.to_do) for fix in rows[2:]] == [
        ("Arm/Joint 0: no limits 0", "set them"), ("joint range: hit", remedy("C-REACH")),
        ("few pieces", "coarser"), ("rests", "x"),
    ]  # fmt: skip
    assert [fix.title for fix in rows[4:]] == ["point 2 of sim-readiness", "point 3 of sim-readiness"]


def test_five_are_named_with_links_and_the_others_are_counted():
    read = section(diagnostics=(*LIMITS, ERROR), checks=(READINESS, REACH, *MASS))
    assert read.marks.count("li") == 5
    assert not read.lacking("and 1 more thing below", "(7 times)", "1 kg <off>")
    codes = ["E-MASS", "C-MASS", "W-LIMIT", "C-REACH", "C-READINESS"]
    assert read.links == [f"file:{code}" for code in codes]


def test_a_report_without_problems_says_so():
    fine = Check("a.xml: mass", True, "fine")
    assert "no error, no warning, and every check passed" in section(checks=(fine,)).text
    assert "every check" not in section().text
    assert "no error, no warning" in section().text


def test_the_few_problems_of_an_error_are_said_once_and_many_are_gathered():
    problem = {"code": "E-MASS", "message": "no mass", "where": "Pin", "hint": "weigh it"}
    error = {"type": "AssemblyError", "message": "no", "where": "", "hint": "", "problems": [problem] * 5}
    assert section(error=error, status="failed").text == ""
    many = section(error={**error, "problems": [problem] * 6}, status="failed")
    assert "(6 times)" in many.text
    assert many.marks.count("li") == 1


def test_a_long_message_is_cut_between_words():
    diagnostics = (Diagnostic("W-LIMIT", "word " * 200, "Arm", "do " * 200),)
    (fix,) = fixes(tree(diagnostics=diagnostics))
    text = section(diagnostics=diagnostics).text
    assert len(fix.to_do) <= 220
    assert text.count(" …") == 2
    assert len(text) < 520
