"""The scene that the configuration asks for raises no alarm, and is what the files must have."""

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from lxml import etree

from linkwright.stages.robot.check import Finding
from tests.support.mutated_builds import Build, built, checks_of, hinge_document


def found(folder: Path) -> list[Finding]:
    codes = ("C-SCENE", "C-PLACE", "C-COMPILE", "C-KEYFRAME")
    return [one for check in checks_of(folder) if check.code in codes for one in check.findings]


MOON = {
    "gravity": [0, 0, -1.62],
    "iterations": 50,
    "integrator": "Euler",
    "o_friction": [1, 1, 0.1, 0.1, 0.1],
}

ASKED: dict[str, Mapping[str, Any]] = {
    "ground": {"ground": {"xyz": [0, 0, -0.3], "rpy": [0.2, 0, 1], "friction": [0.3, 0, 0]}},
    "no ground": {"ground": {"kind": "none"}},
    "free": {"root": {"base": "free"}, "scene": {"pose": {"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]}}},
    "fixed": {"root": {"base": "fixed"}, "scene": {"pose": {"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]}}},
    "moon": {"scene": {"option": {**MOON, "flag": {"contact": "disable", "energy": "enable"}}}},
    "own XML": {
        "attributes": {
            "floor": {"pos": "0 0 -1", "friction": "0 0 0", "euler": "0.1 0 0", "contype": 3},
            "one": {"tag": "body", "pos": "0 0 1"},
        },
    },
    "own option": {
        "elements": {
            "moon": {"into": {"tag": "mujoco", "file": "scene"}, "xml": "<option gravity='0 0 -2'/>"}
        }
    },
}


@pytest.mark.parametrize("asked", ASKED)
def test_what_the_configuration_asks_for_raises_no_alarm(asked: str, tmp_path: Path) -> None:
    assert found(built(hinge_document(), tmp_path / "build", ASKED[asked]).folder) == []


def edited(build: Build, folder: Path, file: str, change: Callable[[etree._Element], None]) -> list[Finding]:
    shutil.copytree(build.folder, folder)
    root = etree.parse(folder / file).getroot()
    change(root)
    (folder / file).write_bytes(etree.tostring(root))
    return found(folder)


def test_what_is_asked_for_must_be_in_the_file(tmp_path: Path) -> None:
    keys = {**ASKED["ground"], **ASKED["moon"], **ASKED["free"]}
    keys["scene"] = {**ASKED["moon"]["scene"], **ASKED["free"]["scene"]}
    build = built(hinge_document(), tmp_path / "build", keys)
    assert found(build.folder) == []

    def as_by_default(root: etree._Element) -> None:
        root.remove(root.find("option"))
        floor = root.find("worldbody/geom[@name='floor']")
        del floor.attrib["quat"], floor.attrib["pos"]

    both = {
        (one.element, one.attribute): one.message
        for one in edited(build, tmp_path / "a", "scene.xml", as_by_default)
    }
    assert both[("option", "gravity")] == "is 0 0 -9.81, expected 0 0 -1.62"
    assert both[("option", "iterations")] == "is 100, expected 50"
    assert both[("flag", "contact")] == "is enabled, expected disabled"
    assert both[('geom "floor"', "pos")].endswith("expected 0 0 -0.3 [m]")
    assert both[('geom "floor"', "quat")].startswith("is tilted by 11.459156 degrees")
    assert ("option", "integrator") not in both

    (one,) = edited(
        build, tmp_path / "b", f"{build.name}.xml", lambda root: root.find("option").set("integrator", "RK4")
    )
    assert one == Finding("option", "integrator", "is rk4, expected euler")
