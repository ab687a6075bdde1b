"""The points of sim-readiness: a robot that meets them, and faults that are found under their numbers."""

import shutil

import mujoco
import pytest

from linkwright.stages.robot.check import Check
from linkwright.stages.robot.model.geometry import ColliderFigures, Geometry, Measures
from linkwright.stages.robot.model.robot import Frame
from linkwright.stages.validate.readiness.finished import FinishedRobot, NotApplicable
from linkwright.stages.validate.readiness.joints import ground_height
from linkwright.stages.validate.readiness.points import POINTS, Point
from linkwright.stages.validate.readiness.score import MISSING, NOT_APPLICABLE, PASSED, judge_point, score
from tests.support.building import plan_of, write
from tests.support.faults.checks import READINESS
from tests.support.robots import at, joint, robot_with
from tests.support.touching import box, geometry_of

SHAPES = {"base": (box(0.2, 0.2, 0.1),), "arm": (box(0.1, 0.1, 0.3),)}


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    tool = Frame("tool", "arm", at(0, 0, 0.1), "")
    robot = robot_with([joint("revolute", "base", "arm", [0.0])], shapes=SHAPES, frames=[tool])
    plan = plan_of(
        actuators={"*": {"type": "position", "encoder": True}},
        joints={"*": {"limits": [-1, 1], "effort": 5, "damping": 0.1, "armature": 0.01}},
    )
    folder = tmp_path_factory.mktemp("good")
    write(robot, folder, plan, geometry_of(robot))
    for name in ("README.md", "LICENSE"):
        (folder / name).write_text(name)
    path = folder / "robot.xml"
    text = path.read_text()
    limits = 'range="-1 1" actuatorfrcrange="-5 5"'
    text = text.replace('<joint name="arm_joint"', f'<joint name="arm_joint" {limits}')
    path.write_text(text)
    return robot, folder


def verdicts(robot, folder, **more):
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    check = score(FinishedRobot(folder, robot, model, **more))
    assert check.passed
    rows = {number: (verdict, words) for number, _, verdict, words in check.table.rows}
    assert check.value == sum(verdict == PASSED for verdict, _ in rows.values())
    assert check.limit == sum(verdict != NOT_APPLICABLE for verdict, _ in rows.values())
    aside = sum(verdict == NOT_APPLICABLE for verdict, _ in rows.values())
    assert f"({aside} of the 35 " in check.detail
    assert "report.html" not in check.detail
    return rows


def test_there_are_thirty_five():
    assert [point.number for point in POINTS] == list(range(1, 36))
    assert len({point.title for point in POINTS}) == 35


def test_fault_counts_where_the_rest_of_a_point_does_not_apply():
    def judge(_):
        yield "a fault"
        raise NotApplicable("there is no ground")

    assert judge_point(Point(1, "", judge), None) == (MISSING, "a fault")


def test_ground_is_the_first_level_plane():
    planes = '<geom type="plane" size="1 1 1" euler="9 0 0"/><geom type="plane" size="1 1 1" pos="0 0 .5"/>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{planes}</worldbody></mujoco>")
    assert ground_height(model) == 0.5


def test_good_robot_misses_nothing(good):
    by_number = verdicts(*good)
    assert {number: words for number, (verdict, words) in by_number.items() if verdict == MISSING} == {}
    aside = [number for number, (verdict, _) in by_number.items() if verdict == NOT_APPLICABLE]
    assert aside == [1, 10, 20, 21, 22, 24, 25, 30, 31]


@pytest.fixture
def copy(good, tmp_path):
    robot, folder = good
    return robot, shutil.copytree(folder, tmp_path / "copy")


@pytest.mark.parametrize("fault", READINESS, ids=lambda fault: fault.kind)
def test_fault_is_found_under_its_number(copy, fault):
    fault.change(copy[1], "robot")
    if fault.kind == "a base that floats" and mujoco.__version__ < "3.4":
        pytest.skip("this MuJoCo refuses keyframes of another length")
    verdict, words = verdicts(*copy)[int(fault.expects)]
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


def test_what_a_published_model_has_beside_it(copy):
    for name in ("README.md", "LICENSE"):
        (copy[1] / name).unlink()
    verdict, words = verdicts(*copy)[35]
    assert verdict == MISSING
    assert "add README.md, LICENSE beside" in words


def test_file_twice_and_one_that_is_no_stl(copy):
    assets = copy[1] / "assets"
    assets.mkdir()
    for name in ("a.stl", "b.stl"):
        (assets / name).write_bytes(bytes(84))
    by_number = verdicts(*copy)
    assert by_number[25][0] == MISSING
    assert "b.stl is the same as a.stl" in by_number[25][1]
    assert "a.stl is not a binary STL" in by_number[25][1]
    assert "nothing uses assets/a.stl" in by_number[3][1]


def test_file_that_broke_ends_no_score(copy):
    (copy[1] / "robot.urdf").write_text("<robot")
    (copy[1] / "robot.json").write_text("{")
    by_number = verdicts(*copy)
    assert by_number[35][0] == MISSING
    assert by_number[35][1].startswith("it cannot be judged: JSONDecodeError")
    assert by_number[2][0] == by_number[18][0] == PASSED


def test_points_about_a_damaged_mjcf_do_not_apply(copy):
    robot, folder = copy
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    (folder / "robot.xml").write_text("<mujoco")
    rows = score(FinishedRobot(folder, robot, model)).table.rows
    assert not any("Malformed" in words for *_, words in rows)
    damaged = {verdict for *_, verdict, words in rows if words == "robot.xml is not XML"}
    assert damaged == {NOT_APPLICABLE}
