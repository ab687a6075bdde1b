"""report.html: whole, escaped, without secrets and without anything from outside."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from pipeline.page import page
from pipeline.report import Report, StageReport
from pipeline.secrets import Secrets
from stages.graph.view.views import OUTLINE, views
from stages.robot.check import Check
from stages.robot.errors import Diagnostic
from tests.unit.test_picture import nasty_robot, random_robot

SECRET = "s3cr3t-&-value"
SHOWN = {name: data.decode() for name, data in views(random_robot(12)).items()}
REPORT = Report(
    status="invalid",
    name="arm <1>",
    folder="outputs/arm",
    until="validate",
    exit_status=3,
    source={"kind": "onshape", "microversion": "m1"},
    calls={"made": 5, "saved": 2, "remaining": {"definition": 40}},
    stages=(StageReport("fetch", True, 0.004, "3 replies"), StageReport("graph", False, 12.5, "2 links")),
    figures={"links": 2, "mass": 1.5, "dof": 1},
    diagnostics=(
        Diagnostic("I-FYI", "as asked"),
        Diagnostic("W-LIMIT", "no <limits> & so on", "Arm/Elbow [left]", "set joints.elbow.limits"),
    ),
    checks=(Check("compiles", True, "ok"), Check("mass", False, "1 kg instead of 2 kg", 1.0, 2.0)),
    outline=tuple(SHOWN[OUTLINE].splitlines()),
    outputs={"arm.urdf": "ab" * 32},
    versions={"linkwright": "0.1.0"},
)


class Reader(HTMLParser):
    """Collects the text and holds that every element is closed in its turn."""

    VOID = frozenset({"meta", "br"})

    def __init__(self, data):
        super().__init__()
        self.open, self.said, self.links = [], [], []
        self.feed(data.decode())
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.links += [value for name, value in attrs if name in ("src", "href", "xlink:href", "data")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.said.append(data)

    @property
    def text(self):
        return "\n".join(self.said)


def made(report=REPORT, shown=SHOWN, secrets=None):
    return page(report, shown, {"arm.urdf": 12345}, Secrets(secrets or {}))


def test_the_page_tells_every_part_of_the_report():
    text = Reader(made()).text
    for words in (
        "arm <1>",
        "invalid",
        "outputs/arm",
        "no <limits> & so on",
        "Arm/Elbow [left]",
        "→ set joints.elbow.limits",
        "Checks: 1 of 2 passed",
        "1 kg instead of 2 kg",
        "12.50",
        "microversion",
        "12,345",
        "ab" * 32,
        "definition: 40",
        "0.1.0",
        "12 links",
        "Joints",
        "hip_",
    ):
        assert words in text
    assert text.index("Warnings") < text.index("For information") < text.index("Kinematic graph")


@pytest.mark.parametrize("robot", [nasty_robot(), random_robot(80)], ids=["nasty", "big"])
def test_it_needs_nothing_from_outside_and_is_well_formed(robot):
    data = made(shown={name: data.decode() for name, data in views(robot).items()})
    assert Reader(data).links == []
    bare = data.decode().replace('xmlns="http://www.w3.org/2000/svg"', "")
    assert not re.search(r"https?:|url\(|@import|<script|<\?xml", bare)
    assert bare.count("<svg") == 1


def test_a_failed_build_tells_its_error_and_what_is_known():
    error = {
        "type": "AssemblyError",
        "message": "two things\nare wrong <here>",
        "where": "Arm",
        "hint": "mend them",
        "problems": [{"code": "E-MASS", "message": "no mass", "where": "Arm/Pin", "hint": ""}],
    }
    report = replace(REPORT, status="failed", error=error, checks=(), outputs={}, outline=(), diagnostics=())
    text = Reader(page(report, {}, {}, Secrets({}))).text
    for words in ("AssemblyError", "are wrong <here>", "→ mend them", "E-MASS", "Arm/Pin"):
        assert words in text
    assert "Kinematic graph" not in text
    assert "Outline" not in text


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
