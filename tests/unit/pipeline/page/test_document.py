"""report.html: whole, escaped, without secrets and without anything from outside."""

import re
from dataclasses import replace

import pytest

from linkwright.pipeline.page.document import page
from linkwright.pipeline.page.head import DOCUMENTS
from linkwright.pipeline.reference.codes import explanations
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.show.graph_view.views import OUTLINE, views
from tests.support.page_reader import Reader
from tests.support.places import PROJECT
from tests.unit.pipeline.test_report import REPORT as PLAIN
from tests.unit.show.graph_view.test_picture import nasty_robot, random_robot

SECRET = "s3cr3t-&-value"
SHOWN = {name: data.decode() for name, data in views(random_robot(12)).items()}
REPORT = replace(
    PLAIN,
    name="arm <1>",
    calls={"made": 5, "saved": 2, "remaining": {"definition": 40}},
    figures={"links": 2, "mass": 1.5, "dof": 1},
    diagnostics=(
        Diagnostic("I-FYI", "as asked"),
        Diagnostic("W-LIMIT", "no <limits> & so on", "Arm/Elbow [left]", "set joints.elbow.limits"),
    ),
    outline=tuple(SHOWN[OUTLINE].splitlines()),
)


def made(report=REPORT, shown=SHOWN, secrets=None):
    return page(report, shown, {"arm.urdf": 12345}, Secrets(secrets or {}))


def test_the_page_tells_every_part_of_the_report():
    read = Reader(made(replace(REPORT, title="Left <arm>")))
    assert not read.lacking(
        "arm <1> (Left <arm>) ", "invalid", "outputs/arm", "no <limits> & so on", "Arm/Elbow [left]",
        "→ set joints.elbow.limits", "Checks: 1 of 2 passed", "1 kg instead of 2 kg", "12.50", "microversion",
        "12,345", "ab" * 32, "definition: 40", "0.1.0", "12 links", "Joints", "upper_",
    )  # fmt: skip
    places = [read.text.index(words) for words in (
        "What to fix first", "Checks: 1 of 2", "Warnings", "For information", "Kinematic graph"
    )]  # fmt: skip
    assert places == sorted(places)


@pytest.mark.parametrize("robot", [nasty_robot(), random_robot(80)], ids=["nasty", "big"])
def test_it_needs_nothing_from_outside_and_is_well_formed(robot):
    data = made(shown={name: data.decode() for name, data in views(robot).items()})
    assert {link for link in Reader(data).links if link[0] != "#"} == {"arm.urdf", *DOCUMENTS}
    bare = data.decode().replace('xmlns="http://www.w3.org/2000/svg"', "")
    assert not re.search(r"https?:|url\(|@import|<script|<\?xml", bare)
    assert bare.count("<svg") == 1


def test_a_failed_build_tells_its_error_and_what_is_known():
    problem = {"code": "E-MASS", "message": "no mass", "where": "Arm/Pin", "hint": ""}
    error = {"type": "AssemblyError", "message": "two things\nare wrong <here>", "where": "Arm"}
    error |= {"hint": "mend them", "problems": [problem]}
    report = replace(REPORT, status="failed", error=error, checks=(), outputs={}, outline=(), diagnostics=())
    words = ("AssemblyError", "are wrong <here>", "→ mend them", "E-MASS", "Arm/Pin")
    absent = ["Kinematic graph", "Outline"]
    assert Reader(page(report, {}, {}, Secrets({}))).lacking(*words, *absent) == absent


def test_secrets_are_blanked_in_text_tables_and_picture():
    robot = replace(random_robot(5), name=f"arm {SECRET}")
    robot = replace(robot, base=replace(robot.base, reason=f"says {SECRET}"))
    shown = {name: data.decode() for name, data in views(robot).items()}
    report = replace(REPORT, outline=tuple(shown[OUTLINE].splitlines()), folder=f"out/{SECRET}")
    before, after = made(report, shown), made(report, shown, {"ONSHAPE_SECRET_KEY": SECRET})
    assert Reader(before).text.count(SECRET) >= 4
    assert SECRET not in Reader(after).text
    assert b"s3cr3t" not in after
    assert "***" in Reader(after).text


@pytest.mark.parametrize("key", ["stroke-width", "translate(", "font-size"])
def test_a_key_that_looks_like_markup_harms_no_picture(key):
    picture = Reader(made(secrets={"ONSHAPE_SECRET_KEY": key}))
    assert "12 links" in picture.text
    assert key.encode() in made(secrets={"ONSHAPE_SECRET_KEY": key})


def check(name, passed=True, **more):
    return Check(name, passed, **{"detail": f"about {name.rpartition(': ')[2]}", **more})


def test_what_failed_is_seen_first_and_what_passed_is_folded():
    checks = (check("arm.xml: mass"), check("arm.xml: poses", passed=False), check("arm.xml: runs"))
    read = Reader(made(replace(REPORT, checks=checks)))
    assert "about mass" in read.folded
    assert "about runs" in read.folded
    assert "about poses" not in read.folded
    assert read.text.index("about poses") < read.text.index("about mass") < read.text.index("Warnings")
    assert "1 of 3 passed" not in read.text
    assert "Checks: 2 of 3 passed" in read.text
    assert "2 passed" in read.text


def test_check_with_the_same_result_in_all_files_has_one_row():
    checks = tuple(check(f"{file}: mass", value=1e-12) for file in ("arm.xml", "scene.xml"))
    checks += (check("arm.urdf: mass", value=2e-12), check("no_warnings"))
    text = Reader(made(replace(REPORT, checks=checks))).text
    assert "Checks: 4 of 4 passed" in text
    assert "arm.xml, scene.xml" in text
    assert text.count("about mass") == 2
    assert text.count("about no_warnings") == 1


def test_every_code_leads_to_what_it_means():
    problems = [{"code": "E-MASS", "message": "no mass", "where": "Pin", "hint": ""}]
    error = {"type": "AssemblyError", "message": "no", "where": "", "hint": "", "problems": problems}
    read = Reader(made(replace(REPORT, error=error)))
    anchors = [target[1:] for target in read.links if target[:3] in ("#E-", "#W-")]
    assert sorted(anchors) == ["E-MASS", "W-LIMIT"]
    for code in anchors:
        first = explanations()[code].meaning.partition("`")[0].strip()
        assert first in read.text
    assert "I-FYI" in read.text
    tables = [(PROJECT / "stages" / name).read_text() for name in ("DIAGNOSTICS.md", "CHECKS.md")]
    rows = [line for table in tables for line in table.splitlines() if line[:3] == "| `"]
    assert len(explanations()) == len(rows) > 100, "the tables are read whole"


def test_files_are_links_and_those_of_meshes_are_folded():
    outputs = {"arm.urdf": "ab" * 32, "graph.svg": "cd" * 32, "assets/left #1.stl": "ef" * 32}
    sizes = {"arm.urdf": 1, "graph.svg": 2, "assets/left #1.stl": 3_000_000}
    read = Reader(page(replace(REPORT, outputs=outputs), SHOWN, sizes, Secrets({})))
    assert {"arm.urdf", "graph.svg", "assets/left%20%231.stl"} <= set(read.links)
    assert "1 in assets/, 3.00 MB" in read.text
    assert "ef" * 32 in read.folded
    assert "ab" * 32 not in read.folded
    failed = Reader(page(replace(REPORT, outputs={}), SHOWN, {}, Secrets({})))
    assert "graph.svg" not in failed.links


def test_the_address_is_a_link_and_nothing_else_from_outside_is():
    url = "https://cad.onshape.com/documents/a/w/b/e/c?configuration=x&y"
    read = Reader(made(replace(REPORT, source={"kind": "onshape", "url": url})))
    assert [target for target in read.links if ":" in target] == [url]
    script = Reader(made(replace(REPORT, source={"kind": "onshape", "url": "javascript:alert(1)"})))
    assert not any(":" in target for target in script.links)


def test_on_a_narrow_screen_each_cell_has_its_columns_title():
    data = made().decode()
    rows = re.findall(r"<tr>(?:<t[dh].*?)</tr>", data)
    labels = re.findall(r'<td[^>]* data-label="([^"]+)"', data)
    assert {"range", "parent", "result", "seconds", "SHA-256"} <= set(labels)
    heads = re.findall(r'<th scope="row">(?:<a href="[^"]*">)?([^<]+)', data)
    assert {"mass", "graph", "arm.urdf"} <= set(heads)
    assert len(rows) > 12
    for rule in ("max-width: 700px", "@media print", "prefers-color-scheme: dark", "attr(data-label)"):
        assert rule in data
