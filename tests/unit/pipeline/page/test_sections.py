"""Sections of report.html and report.json: fixes, orders, checks, pairs of colliders, variants."""

import json
from dataclasses import replace

import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.page.document import page
from linkwright.pipeline.page.files import variants
from linkwright.pipeline.page.fix_first import fix_first, fixes
from linkwright.pipeline.page.order import order
from linkwright.pipeline.reference.codes import remedy
from linkwright.pipeline.report import Report
from linkwright.pipeline.run.build import build
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.terminal.closing import closing_lines
from linkwright.stages.export import export
from linkwright.stages.robot import codec
from linkwright.stages.robot.check import Check, Finding, Table
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Geometry
from tests.support.building import plan_of
from tests.support.page_reader import Reader
from tests.unit.export.test_variants import hinges
from tests.unit.pipeline.page.test_document import REPORT


def rows(keys, *values):
    return [dict(zip(keys.split(), row, strict=True)) for row in values]


TABLES = {
    "mjcf": {
        "joints": rows(
            "name kind unit qpos dof urdf cad",
            ("ball", "ball", "quaternion (w, x, y, z)", [7, 4], [6, 3], ["ball_x", "ball_y", "ball_z"],
             "Ball <1>"),
            ("elbow", "turn", "rad", [12, 1], [10, 1], ["elbow"], None),
            ("lift", "slide", "m", [11, 1], [9, 1], [], None),
        ),
        "actuators": rows("name ctrl type joint unit range cad", (
            "push", [3, 2], "motor", "lift", "N", [-5.0, 5.0], None,
        )),
        "sensors": rows(
            "name index type on address dim unit cad",
            ("imu", 0, "gyro", "tip", 2, 3, "rad/s", None),
            ("odd", 1, "plugin", None, 5, None, None, None),
        ),
    },
    "urdf": {
        "joints": rows("name index tree type unit follows dof cad", (
            "lift", 4, 6, "prismatic", "m", "ball_x", "lift", None,
        )),
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The reports of two builds of the sample in one folder, and the folder."""
    folder = tmp_path_factory.mktemp("contacts")
    keys = ["robot=sample", "mesh=hull", "mesh.colliders={Wrist:box}", "sensors.all=joint"]
    plan = compose_plan([*keys, f"output={folder}/out", f"cache.dir={folder}/cache"], cwd=folder).plan
    return build(plan), build(plan), folder / "out"


def test_the_page_has_a_table_of_each_that_is_there():
    read = Reader(page(replace(REPORT, details={"order": TABLES}), {}, {"arm.urdf": 1}, Secrets({})))
    assert not read.lacking(
        "Joints in the order of MuJoCo", "hinge", "7 to 10", "6 to 8", "ball_x, ball_y, ball_z", "Ball <1>",
        "Actuators in the order of ctrl", "-5 to 5", "3 to 4", "Sensors in the order of sensordata", "2 to 4",
        "Joints in the order of the URDF", "prismatic",
    )  # fmt: skip
    assert "None" not in read.text
    assert order({}) == ""
    assert "sensordata" not in order({"mjcf": {**TABLES["mjcf"], "sensors": []}})


@pytest.mark.e2e
def test_report_has_the_orders_of_robot_json(built):
    first, second, folder = built
    expected = json.loads((folder / "robot.json").read_text())["order"]
    assert len(expected["mjcf"]["sensors"]) == 2 * len(expected["urdf"]["joints"])
    assert first.details["order"] == second.details["order"] == expected


JOINED = [("lift_column", "turret"), ("elbow_plate", "parallel_rod")]
"""A joint's links, and a loop's."""


@pytest.mark.e2e
def test_the_report_has_each_pair_with_its_reason_and_depth(built):
    first, _, folder = built
    rows = json.loads((folder / "report.json").read_text())["details"]["excludes"]
    assert rows == first.details["excludes"]
    by_links = {tuple(row["links"]): row for row in rows}
    base = by_links["base_plate", "lift_column"]
    assert base["reason"] == "Adjacent"
    # They overlap by 93 mm along the column; the shortest way apart is across it.
    assert 60 < base["depth"] < 94
    assert set(JOINED) <= {tuple(sorted(pair)) for pair in by_links}
    page = (folder / "report.html").read_text()
    for words in ("Links that do not collide", "base_plate", "lift_column", "Adjacent"):
        assert words in page


@pytest.mark.e2e
def test_colliders_of_an_unchanged_robot_keep_their_time(built):
    first, second, folder = built
    before, after = first.details["colliders"], second.details["colliders"]
    assert len(before) == 11
    assert all(row["seconds"] > 0 and not row["cached"] for row in before)
    assert after == [{**row, "cached": True} for row in before]
    assert second.details["links"] == first.details["links"]
    assert second.details["excludes"] == first.details["excludes"]
    assert all(stage.cached for stage in second.stages if stage.name != "fetch")
    assert all(check.passed for check in first.checks)
    page = (folder / "report.html").read_text()
    assert page.count("data:image/png;base64,") == 1  # of the link with a box, which was judged
    assert "0 of 11 colliders made in this build" in page


SCORE = Check(
    "arm.xml: sim-readiness", True, "30 of 33 points", 30.0, 33.0, "C-READINESS", "warning",
    table=Table(("point", "what", ""), ((1, "loads <everywhere>", "passed"), (2, "a scene", None))),
)  # fmt: skip
BARE = Check("arm.xml: compiles", True, "fine")


def report(*checks):
    return Report(status="built", name="arm", folder="out", until="validate", exit_status=0, checks=checks)


def html(*checks):
    return page(report(*checks), {}, {}, Secrets({}))


def test_table_of_a_check_reaches_page_report_and_terminal():
    assert codec.decode_checks(codec.encode_checks((SCORE,))) == (SCORE,)
    shown = html(SCORE).decode()
    assert "sim-readiness: 30 of 33 points" in shown
    assert "loads &lt;everywhere&gt;" in shown
    assert ">None<" not in shown
    tree = json.loads(report(SCORE).to_json())
    assert tree["checks"][0]["table"]["rows"][0] == [1, "loads <everywhere>", "passed"]
    line = "arm.xml: sim-readiness: 30 of 33 points (report.html has the table)"
    assert closing_lines(report(SCORE)).count(line) == 1
    assert not [line for line in closing_lines(report(BARE)) if "compiles" in line]
    assert b"compiles: fine" not in html(BARE), "a check without a table has none"


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


def test_each_origin_has_a_row_with_its_share():
    plan = plan_of(actuators={"*": "position"}, variants={"n": 9, "seed": 4})
    details = export(hinges(), Geometry((), {}), plan).details["variants"]
    shown = variants(details)
    assert "9 variants of the seed 4" in shown
    assert shown.index("±10 %") < shown.index("±30 %")
    assert [row["origin"] for row in details["rows"]] == ["source", "estimated"]
    assert "links.base.mass" in shown
    assert export(hinges(), Geometry((), {}), plan_of()).details.get("variants") is None
    assert variants({}) == ""
    more = len(details["rows"][0]["of"]) - 6
    assert f" and {more} more" in shown


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


def test_many_problems_of_an_error_are_one_fix():
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
