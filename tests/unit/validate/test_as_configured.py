"""What the configuration asks for, or its own XML sets, raises no alarm and is what the files must have."""

import pytest
from lxml import etree

from linkwright.stages.robot.check import Finding
from tests.support.mutated_builds import built, checks_of, hinge_document

ENDS = "geom1='one_collision' geom2='other_collision'"
FRICTION = {"geoms": {"one*": {"collision": {"friction": [0.5, 0.01, 0.001], "condim": 4, "priority": 1}}}}
NO_FRICTION = {"attributes": {"other_collision": {"friction": "0 0 0", "margin": 0.001}}}
CLASS = {"elements": {"grip": {"into": {"tag": "default"}, "xml": "<geom friction='2 0.1 0.1'/>"}}}
PAIR = {"elements": {"touch": {"into": {"tag": "contact"}, "xml": f"<pair {ENDS}/>"}}}
OPTION = {
    "gravity": [0, 0, -1.62],
    "iterations": 50,
    "integrator": "Euler",
    "o_friction": [1, 1, 0.1, 0.1, 0.1],
}
MOON = {"option": {**OPTION, "flag": {"contact": "disable", "energy": "enable"}}}
PLACE = {"pose": {"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]}}
GROUND = {"xyz": [0, 0, -0.3], "rpy": [0.2, 0, 1], "friction": [0.3, 0, 0]}
FLOOR = {"pos": "0 0 -1", "friction": "0 0 0", "euler": "0.1 0 0", "contype": 3}
GRAVITY = {"into": {"tag": "mujoco", "file": "scene"}, "xml": "<option gravity='0 0 -2'/>"}

KEYS = {
    "friction": FRICTION,
    "no friction": NO_FRICTION,
    "class": CLASS,
    "pair": PAIR,
    "friction of both": {**FRICTION, **NO_FRICTION},
    "ground": {"ground": GROUND},
    "no ground": {"ground": {"kind": "none"}},
    "free": {"root": {"base": "free"}, "scene": PLACE},
    "fixed": {"root": {"base": "fixed"}, "scene": PLACE},
    "moon": {"scene": MOON},
    "floor": {"attributes": {"floor": FLOOR, "one": {"tag": "body", "pos": "0 0 1"}}},
    "gravity": {"elements": {"moon": GRAVITY}},
}


@pytest.fixture
def build(tmp_path):
    """Builds a hinge with these keys."""
    return lambda keys: built(hinge_document(), tmp_path / "build", keys)


def findings(folder, *codes):
    return [finding for check in checks_of(folder) if check.code in codes for finding in check.findings]


CONTACT, SCENE = ("C-CONTACT", "C-EXCLUDE", "C-SHAPE"), ("C-SCENE", "C-PLACE", "C-COMPILE", "C-KEYFRAME")


@pytest.mark.parametrize("kind", KEYS)
def test_what_the_configuration_asks_for_raises_no_alarm(kind, build):
    assert findings(build(KEYS[kind]).folder, *CONTACT, *SCENE) == []


def edit(path, change):
    root = etree.parse(path).getroot()
    change(root)
    path.write_bytes(etree.tostring(root))


def test_contact_that_is_asked_for_must_be_in_the_file(build):
    made = build(FRICTION)

    def as_by_default(root):
        (geom,) = root.xpath("//geom[@condim='4']")
        del geom.attrib["condim"], geom.attrib["friction"]

    edit(made.folder / f"{made.name}.xml", as_by_default)
    messages = {finding.attribute: finding.message for finding in findings(made.folder, *CONTACT)}
    wrong = {"friction": "is 1 0.005 0.0001, expected 0.5 0.01 0.001", "condim": "is 3, expected 4"}
    assert messages == wrong


def test_collider_that_is_added_in_front_is_named_and_no_other(build):
    made = build({})
    path = made.folder / f"{made.name}.xml"
    path.write_text(path.read_text().replace("<geom name=", '<geom type="sphere" size="0.1"/><geom name=', 1))
    (check,) = [
        problem for problem in checks_of(made.folder) if problem.code == "C-SHAPE" and problem.findings
    ]
    assert check.detail == '1 more than the robot has: geom of body "one"'
    (finding,) = check.findings
    assert finding.message == 'is a collision shape more than the robot\'s body "one" has'


def test_scene_that_is_asked_for_must_be_in_the_file(build):
    made = build({"ground": GROUND, "root": {"base": "free"}, "scene": {**MOON, **PLACE}})
    assert findings(made.folder, *SCENE) == []
    robot, scene = made.folder / f"{made.name}.xml", made.folder / "scene.xml"
    before = robot.read_bytes()
    edit(robot, lambda root: root.find("option").set("integrator", "RK4"))
    assert findings(made.folder, *SCENE) == [Finding("option", "integrator", "is rk4, expected euler")]
    robot.write_bytes(before)

    def as_by_default(root):
        root.remove(root.find("option"))
        floor = root.find("worldbody/geom[@name='floor']")
        del floor.attrib["quat"], floor.attrib["pos"]

    edit(scene, as_by_default)
    messages = {(row.element, row.attribute): row.message for row in findings(made.folder, *SCENE)}
    assert messages[("option", "gravity")] == "is 0 0 -9.81, expected 0 0 -1.62"
    assert messages[("option", "iterations")] == "is 100, expected 50"
    assert messages[("flag", "contact")] == "is enabled, expected disabled"
    assert messages[('geom "floor"', "pos")].endswith("expected 0 0 -0.3 [m]")
    assert messages[('geom "floor"', "quat")].startswith("is tilted by 11.459156 degrees")
    assert ("option", "integrator") not in messages


@pytest.mark.parametrize("package", [None, "arm_description"])
def test_meshes_of_the_package_that_was_asked_for_are_found(package, build):
    made = build({"export": {"urdf": {"meshes": "package", "package": package}, "mjcf": {}}})
    path = made.folder / f"{made.name}.urdf"
    assert findings(made.folder, "C-PATH") == []
    text, assets = path.read_text(), f"package://{package or made.name}/assets"
    assert assets in text
    path.write_text(text.replace(assets, "package://other/assets", 1))
    (finding,) = findings(made.folder, "C-PATH")
    assert 'no folder of a package "other" has this file' in finding.message


def test_velocity_that_is_gone_is_said_to_be_missing(build):
    made = build({"joints": {"*": {"velocity": 3, "effort": 2}}})
    path = made.folder / f"{made.name}.urdf"
    path.write_text(path.read_text().replace(' velocity="3"', "", 1))
    rows = [finding for check in checks_of(made.folder) for finding in check.findings]
    assert [row.message for row in rows if row.attribute == "limit velocity"] == ["is missing, expected 3"]
