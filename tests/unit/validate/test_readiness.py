"""The points of sim-readiness: a robot that meets them, and faults that are found under their numbers."""

import re
from pathlib import Path

import mujoco
import pytest

from linkwright.stages.export import export
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.model.geometry import ColliderFigures, Geometry, Measures
from linkwright.stages.robot.model.robot import Frame, Robot
from linkwright.stages.validate.readiness.finished import Finished
from linkwright.stages.validate.readiness.points import POINTS
from linkwright.stages.validate.readiness.score import ASIDE, MISSING, PASSED, score
from tests.support.building import plan_of
from tests.support.robots import at, joint, robot_with
from tests.support.touching import box, geometry_of

SHAPES = {"base": (box(0.2, 0.2, 0.1),), "arm": (box(0.1, 0.1, 0.3),)}


@pytest.fixture(scope="module")
def good(tmp_path_factory) -> tuple[Robot, Path]:
    tool = Frame("tool", "arm", at(0, 0, 0.1), "")
    robot = robot_with([joint("revolute", "base", "arm", [0.0])], shapes=SHAPES, frames=[tool])
    plan = plan_of(
        actuators={"*": {"type": "position", "encoder": True}},
        joints={"*": {"limits": [-1, 1], "effort": 5, "damping": 0.1, "armature": 0.01}},
    )
    folder = tmp_path_factory.mktemp("good")
    for name, data in export(robot, geometry_of(robot), plan).files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    for name in ("README.md", "LICENSE"):
        (folder / name).write_text(name)
    path = folder / "robot.xml"
    text = path.read_text()
    limits = 'range="-1 1" actuatorfrcrange="-5 5"'
    text = text.replace('<joint name="arm_joint"', f'<joint name="arm_joint" {limits}')
    path.write_text(text)
    return robot, folder


def verdicts(robot: Robot, folder: Path, **more) -> dict[int, tuple[str, str]]:
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    check = score(Finished(folder, robot, model, **more))
    assert check.passed
    found = {number: (verdict, words) for number, _, verdict, words in check.table.rows}
    assert check.value == sum(verdict == PASSED for verdict, _ in found.values())
    assert check.limit == sum(verdict != ASIDE for verdict, _ in found.values())
    aside = sum(verdict == ASIDE for verdict, _ in found.values())
    assert f"({aside} of the 35 " in check.detail
    assert "report.html" not in check.detail
    return found


def test_there_are_thirty_five():
    assert [point.number for point in POINTS] == list(range(1, 36))
    assert len({point.title for point in POINTS}) == 35


def test_a_good_robot_misses_nothing(good):
    found = verdicts(*good)
    assert {number: words for number, (verdict, words) in found.items() if verdict == MISSING} == {}
    aside = [number for number, (verdict, _) in found.items() if verdict == ASIDE]
    assert aside == [1, 10, 20, 21, 22, 24, 25, 30, 31]


ROBOT, SCENE = "robot.xml", "scene.xml"
MOMENTS = 'diaginertia="0.0044 0.0055 0.0066"'
FULL = 'mass="1.1" fullinertia="4e-3 4e-3 4e-3 0 0 0"'
NO_INERTIAL = r'(?s)(name="arm".*?)<inertial [^>]*/>'
FAULTS = {
    "a light in the robot's file": (2, ROBOT, "<worldbody>", '<worldbody><light pos="0 0 1"/>'),
    "no ground": (2, SCENE, r'<geom name="floor"[^>]*/>', ""),
    "degrees": (3, ROBOT, 'angle="radian"', 'angle="degree"'),
    "no classes": (4, ROBOT, 'class="visual"', 'class="seen"'),
    "a geom without a class": (4, ROBOT, 'class="collision" type', 'type'),
    "one group": (5, ROBOT, 'group="3"', 'group="2"'),
    "no collider": (6, ROBOT, r'<geom name="arm_collision"[^>]*/>', ""),
    "no inertia": (7, ROBOT, NO_INERTIAL, r'\1<geom type="box" size=".1 .1 .1" mass="1"/>'),
    "an inertia of a larger body": (9, ROBOT, MOMENTS, 'diaginertia="1 1 1"'),
    "a centre of mass elsewhere": (9, ROBOT, 'pos="0.02 -0.01 0.03"', 'pos="2 0 0"'),
    "next to no mass": (11, ROBOT, 'mass="1.1"', 'mass="1e-5"'),
    "two conventions": (11, ROBOT, rf'quat="[^"]*" mass="1.1" {MOMENTS}', FULL),
    "a body that stays": (12, ROBOT, "</worldbody>", "{more}</worldbody>"),
    "a lost frame": (13, ROBOT, r'<site name="tool"[^>]*/>', ""),
    "home out of range": (14, ROBOT, 'range="-1 1" actuatorfrcrange', 'range="0.5 1" actuatorfrcrange'),
    "no armature": (15, ROBOT, r'armature="[^"]*"', 'armature="0"'),
    "a force without a bound": (15, ROBOT, 'actuatorfrcrange="-5 5"', ""),
    "controls beyond the range": (16, ROBOT, '<position ', '<position ctrlrange="-9 9" '),
    "a name with a space": (17, ROBOT, 'name="tool"', 'name="the tool"'),
    "an actuator of another name": (18, ROBOT, '<position name="arm_joint"', '<position name="motor"'),
    "no home": (19, ROBOT, '<key name="home"', '<key name="start"'),
    "a colour of its own": (26, ROBOT, 'material="light_grey"', 'rgba="1 0 0 1"'),
    "no time step": (27, ROBOT, 'timestep="0.002" ', ""),
    "a base that floats": (28, ROBOT, r'(<body name="base"[^>]*>)', r"\1<freejoint/>"),
    "nothing measured": (29, ROBOT, r"(?s)<sensor>.*</sensor>", ""),
    "noise": (33, ROBOT, 'pos="0.02 -0.01 0.03"', 'pos="0.02 -0.01 3e-17"'),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_found_under_its_number(good, tmp_path, name):
    robot, folder = good
    number, file, old, new = FAULTS[name]
    for path in folder.iterdir():
        if path.is_file():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    text = (tmp_path / file).read_text()
    if name == "a body that stays":
        old = r"(?s)(<body name=\"arm\".*?)</body>"
        new = r'\1<body name="more"><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/></body></body>'
    if name in ("nothing measured", "no home", "a base that floats"):
        # What refers to it goes, too.
        text = text.replace(' ctrl="0"', "") if name != "nothing measured" else text
    changed = re.sub(old, new, text, count=0 if name == "no classes" else 1)
    assert changed != text
    if name == "a base that floats":
        changed = re.sub(r'qpos="0"', 'qpos="0 0 0.05 1 0 0 0 0"', changed)
    if name == "an actuator of another name":
        changed = changed.replace('actuator="arm_joint"', 'actuator="motor"')
    (tmp_path / file).write_text(changed)
    verdict, words = verdicts(robot, tmp_path)[number]
    assert verdict == MISSING, words
    assert words


PROVED = {1: "COMPILE", 10: "MASS", 20: "REST", 21: "NOISE", 22: "START", 31: "PARITY"}


@pytest.mark.parametrize(("number", "kind"), PROVED.items())
def test_what_other_checks_prove_is_taken_from_them(good, number, kind):
    for passed, verdict in ((True, PASSED), (False, MISSING)):
        proof = Check("robot.xml: it", passed, "so and so", code=f"C-{kind}")
        assert verdicts(*good, checks=[proof])[number][0] == verdict


def test_colliders_out_of_their_tolerance(good):
    measures = Measures(0.0, 0.0, "boolean", 0.1, 0.1, 0.1, 0.1)
    figures = ColliderFigures("arm", ("part",), "ladder", "hull", 1, 8, True, 0.05, measures, miss=0.9)
    assert verdicts(*good, geometry=Geometry((), {}, colliders=(figures,)))[24][0] == PASSED
    off = ColliderFigures("arm", ("part",), "ladder", "hull", 1, 8, False, 0.05, measures, miss=2.0)
    assert verdicts(*good, geometry=Geometry((), {}, colliders=(off,)))[24][0] == MISSING


def test_what_a_published_model_has_beside_it(good, tmp_path):
    robot, folder = good
    for path in folder.iterdir():
        if path.suffix in (".xml", ".json", ".urdf"):
            (tmp_path / path.name).write_bytes(path.read_bytes())
    verdict, words = verdicts(robot, tmp_path)[35]
    assert verdict == MISSING
    assert "add README.md, LICENSE beside" in words


def test_a_file_twice_and_one_that_is_no_stl(good, tmp_path):
    robot, folder = good
    for path in folder.iterdir():
        if path.is_file():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / "a.stl").write_bytes(bytes(84))
    (tmp_path / "assets" / "b.stl").write_bytes(bytes(84))
    found = verdicts(robot, tmp_path)
    assert found[25][0] == MISSING
    assert "b.stl is the same as a.stl" in found[25][1]
    assert "a.stl is no binary STL" in found[25][1]
    assert "nothing uses assets/a.stl" in found[3][1]


def test_a_file_that_broke_ends_no_score(good, tmp_path):
    robot, folder = good
    for path in folder.iterdir():
        if path.is_file():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / "robot.urdf").write_text("<robot")
    (tmp_path / "robot.json").write_text("{")
    found = verdicts(robot, tmp_path)
    assert found[35][0] == MISSING
    assert found[35][1].startswith("it cannot be judged: JSONDecodeError")
    assert found[2][0] == found[18][0] == PASSED
