"""What the configuration gives colliders, or its own XML sets, is what they must have."""

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from lxml import etree

from linkwright.stages.robot.check import Check
from tests.support.mutated_builds import built, checks_of, hinge_document


def found(folder: Path) -> list[Check]:
    return [
        one
        for one in checks_of(folder)
        if one.code in ("C-CONTACT", "C-EXCLUDE", "C-SHAPE") and not one.passed
    ]


ENDS = "geom1='one_collision' geom2='other_collision'"
GIVEN = {"geoms": {"one*": {"collision": {"friction": [0.5, 0.01, 0.001], "condim": 4, "priority": 1}}}}
OWN: dict[str, Any] = {"attributes": {"other_collision": {"friction": "0 0 0", "margin": 0.001}}}
CLASS = {"elements": {"grip": {"into": {"tag": "default"}, "xml": "<geom friction='2 0.1 0.1'/>"}}}
PAIR = {"elements": {"touch": {"into": {"tag": "contact"}, "xml": f"<pair {ENDS}/>"}}}


@pytest.mark.parametrize("keys", [GIVEN, OWN, CLASS, PAIR, {**GIVEN, **OWN}])
def test_what_the_configuration_asks_for_raises_no_alarm(keys: Mapping[str, Any], tmp_path: Path) -> None:
    assert found(built(hinge_document(), tmp_path / "build", keys).folder) == []


def test_what_is_given_must_be_in_the_file(tmp_path: Path) -> None:
    build = built(hinge_document(), tmp_path / "build", GIVEN)
    folder = shutil.copytree(build.folder, tmp_path / "edited")
    root = etree.parse(folder / f"{build.name}.xml").getroot()
    (geom,) = root.xpath("//geom[@condim='4']")
    del geom.attrib["condim"], geom.attrib["friction"]
    (folder / f"{build.name}.xml").write_bytes(etree.tostring(root))
    (check,) = found(folder)
    messages = {one.attribute: one.message for one in check.findings}
    assert messages == {
        "friction": "is 1 0.005 0.0001, expected 0.5 0.01 0.001",
        "condim": "is 3, expected 4",
    }


def test_a_collider_that_is_added_in_front_is_named_and_no_other(tmp_path: Path) -> None:
    build = built(hinge_document(), tmp_path / "build", {})
    path = build.folder / f"{build.name}.xml"
    path.write_text(path.read_text().replace("<geom name=", '<geom type="sphere" size="0.1"/><geom name=', 1))
    (check,) = [one for one in found(build.folder) if one.code == "C-SHAPE"]
    assert check.detail == '1 more than the robot has: geom of body "one"'
    (finding,) = check.findings
    assert finding.message == 'is a collision shape more than the robot\'s body "one" has'
