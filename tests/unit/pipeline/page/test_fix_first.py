"""What to fix first: the gravest, each kind once, with what to do and where it is explained."""

from dataclasses import replace

from linkwright.pipeline.page.fix_first import fix_first, fixes
from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.robot.check import Check, Finding, Table
from linkwright.stages.robot.errors import Diagnostic
from tests.support.page_reader import Reader
from tests.unit.pipeline.page.test_document import REPORT

LIMITS = tuple(Diagnostic("W-LIMIT", f"no limits {i}", f"Arm/Joint {i}", "set them") for i in range(7))
READINESS = Check(
    "arm.xml: sim-readiness",
    True,
    "1 of 3 points",
    code="C-READINESS",
    level="warning",
    table=Table(
        ("point", "what a model should have", "", "what would raise it"),
        ((1, "loads", "passed", ""), (2, "few pieces", "missing", "coarser"), (3, "rests", "missing", "x")),
    ),
)
MASS = tuple(Check(f"{file}: mass", False, "1 kg <off>", 1.0, 0.0, "C-MASS") for file in ("a.xml", "a.urdf"))
REACH = Check(
    "a.xml: reach", False, "2", code="C-REACH", level="warning", findings=(Finding("joint", "range", "hit"),)
)


def of(**more):
    return fixes(replace(REPORT, **{"diagnostics": (), "checks": (), **more}).tree())


def section(**more):
    tree = replace(REPORT, **{"diagnostics": (), "checks": (), **more}).tree()
    return Reader(fix_first(tree, fixes(tree)).replace("#", "file:").encode())


def test_the_gravest_are_first_and_those_of_a_kind_are_one() -> None:
    info = Diagnostic("I-FYI", "as asked")
    error = Diagnostic("E-MASS", "no mass", "Pin")
    found = of(diagnostics=(info, *LIMITS, error), checks=(READINESS, REACH, *MASS))
    assert [(fix.rank, fix.code, fix.count) for fix in found] == [
        ("error", "E-MASS", 1),
        ("failed", "C-MASS", 1),
        ("warning", "W-LIMIT", 7),
        ("warning", "C-REACH", 1),
        ("readiness", "C-READINESS", 1),
        ("readiness", "C-READINESS", 1),
    ]
    assert found[1].title == "mass in a.xml, a.urdf"
    assert (found[2].found, found[2].to_do) == ("Arm/Joint 0: no limits 0", "set them")
    assert (found[3].found, found[3].to_do) == ("joint range: hit", remedy("C-REACH"))
    assert [(fix.title, fix.found, fix.to_do) for fix in found[4:]] == [
        ("point 2 of sim-readiness", "few pieces", "coarser"),
        ("point 3 of sim-readiness", "rests", "x"),
    ]


def test_five_are_named_and_the_others_counted_and_each_leads_to_its_explanation() -> None:
    diagnostics = (*LIMITS, Diagnostic("E-MASS", "no mass", "Pin"))
    read = section(diagnostics=diagnostics, checks=(READINESS, REACH, *MASS))
    assert read.marks.count("li") == 5
    assert "and 1 more thing below" in read.text
    assert "(7 times)" in read.text
    codes = ["E-MASS", "C-MASS", "W-LIMIT", "C-REACH", "C-READINESS"]
    assert read.links == [f"file:{code}" for code in codes]
    assert "1 kg <off>" in read.text


def test_where_nothing_is_wrong_it_says_so() -> None:
    fine = Check("a.xml: mass", True, "fine")
    assert "no error, no warning, and every check passed" in section(checks=(fine,)).text
    assert "every check" not in section().text
    assert "no error, no warning" in section().text


def test_the_few_problems_of_an_error_are_said_once_and_many_are_gathered() -> None:
    problem = {"code": "E-MASS", "message": "no mass", "where": "Pin", "hint": "weigh it"}
    error = {"type": "AssemblyError", "message": "no", "where": "", "hint": "", "problems": [problem] * 5}
    assert section(error=error, status="failed").text == ""
    many = section(error={**error, "problems": [problem] * 6}, status="failed")
    assert "(6 times)" in many.text
    assert many.marks.count("li") == 1


def test_a_long_message_is_cut_between_words() -> None:
    long = Diagnostic("W-LIMIT", "word " * 200, "Arm", "do " * 200)
    (fix,) = of(diagnostics=(long,))
    text = section(diagnostics=(long,)).text
    assert len(fix.to_do) <= 220
    assert text.count(" …") == 2
    assert len(text) < 520
