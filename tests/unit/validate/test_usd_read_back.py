"""The checks of a USD that was read back: the good one passes, and each fault fails what is meant for it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.model.poses import at_rest, from_parts, turn
from linkwright.stages.robot.model.robot import Actuator, Dynamics, Limits, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.support.building import NO_MESHES, plan_of
from tests.support.faults.checks import DRIVES, USD
from tests.support.robots import EVERY, LOOPS, joint, loop, pose, robot_with
from tests.support.usd import pxr


def text_of(robot: Robot) -> str:
    assert pxr.Usd
    return export(robot, NO_MESHES, plan_of(export={"usd": {}})).files["robot.usda"].decode()


def checked(
    robot: Robot, text: str, folder: Path, *, quick: bool = False, written: Written | None = None
) -> list[Check]:
    assert pxr.Usd
    from linkwright.stages.validate.read.usd import check_file

    (folder / "robot.usda").write_text(text)
    (folder / "robot_meshes.usd").write_text("#usda 1.0\n")
    return list(check_file(folder / "robot.usda", written or Written(robot), quick=quick))


def failed(checks: list[Check]) -> list[str]:
    return [check.name.partition(": ")[2] for check in checks if check.fails]


@pytest.mark.parametrize("fixed", [True, False])
@pytest.mark.parametrize("kind", EVERY)
def test_every_joint_passes_every_check(kind, fixed, tmp_path):
    rng = np.random.default_rng(EVERY.index(kind))
    root = "world" if kind == "free" else "base"
    rows = [
        joint(kind, root, "one", place=pose(rng), origins=[pose(rng), pose(rng), pose(rng)]),
        joint("ball", "one", "two", [(0.8, 0.0, 0.6, 0.0)], place=pose(rng)),
    ]
    robot = robot_with(rows, root=root, fixed=fixed or kind == "free")
    assert failed(checked(robot, text_of(robot), tmp_path)) == []


ANGLES = (3e-9, 4e-8, 1.1e-7, 3e-6, 1.3e-5, 4.7e-4, 7.7e-3, 0.3, 3.0)


@pytest.mark.parametrize("angle", ANGLES)
def test_a_link_that_is_turned_by_any_angle_stands_where_it_is(angle, tmp_path):
    turned = from_parts(turn(np.array([0.6, 0.0, 0.8]), angle), np.array([0.3, 0.2, 0.1]))
    robot = robot_with([joint("revolute", "base", "arm", name="elbow", place=turned)], fixed=True)
    text = text_of(robot)
    assert failed(checked(robot, text, tmp_path)) == []
    stage = pxr.Usd.Stage.Open(str(tmp_path / "robot.usda"))
    prim = next(prim for prim in stage.Traverse() if prim.GetName() == "arm")
    placed = np.array(pxr.UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0)).T
    off = np.abs(placed - turned).max()
    # USD finds the angle as 2 arccos w, where w has steps of 1.1e-16.
    assert off < min(3e-8, 4e-16 / angle + 1e-11)
    more = from_parts(turn(np.array([0.6, 0.0, 0.8]), angle + 1e-7), turned[:3, 3])
    other = robot_with([joint("revolute", "base", "arm", name="elbow", place=more)], fixed=True)
    assert "home" in failed(checked(other, text, tmp_path))


def test_a_link_may_have_the_name_of_its_robot(tmp_path):
    rows = [joint("revolute", "base", "robot"), joint("prismatic", "robot", "hand")]
    robot = robot_with(rows, fixed=True)
    assert robot.name == "robot"
    assert failed(checked(robot, text_of(robot), tmp_path)) == []


def looped(kind: str, shifted: bool = False) -> Robot:
    rng = np.random.default_rng(LOOPS.index(kind))
    rows = [
        joint("planar", "base", "one", [0.2, -0.1, 0.4], place=pose(rng)),
        joint("revolute", "one", "two", [0.3], place=pose(rng)),
    ]
    robot = robot_with(rows)
    poses, near = link_poses(robot, {dof.name: dof.saved for dof in robot.dofs}), pose(rng)
    shut = loop(kind, "two", "base", near, poses["two"] @ near, name="shut")
    shut = replace(shut, dofs=tuple(replace(dof, saved=at_rest(dof.kind)) for dof in shut.dofs))
    if shifted:
        mate = joint(kind, "base", "end", name="shut", origins=[pose(rng) for _ in range(3)])
        across = link_poses(robot_with([mate]), {})["end"]
        shut = replace(shut, dofs=mate.dofs, b_from_frame=poses["two"] @ near @ np.linalg.inv(across))
    return replace(robot, loops=(shut,))


@pytest.mark.parametrize("shifted", [False, True])
@pytest.mark.parametrize("kind", LOOPS)
def test_every_loop_passes_every_check(kind, shifted, tmp_path):
    robot = looped(kind, shifted)
    assert failed(checked(robot, text_of(robot), tmp_path)) == []


def good() -> Robot:
    limits = {"elbow": Limits(-1, 2), "slide": Limits(None, 0.5)}
    rows = [
        joint("revolute", "base", "arm", name="elbow", limits=limits, dynamics=Dynamics(0.1)),
        joint("prismatic", "arm", "hand", name="slide", limits=limits),
    ]
    return replace(robot_with(rows), loops=(loop("ball", "hand", "base", np.eye(4), np.eye(4), name="shut"),))


@pytest.fixture(scope="module")
def exports(tmp_path_factory):
    """The exported files of the good robot, without and with a servo; their checks pass."""
    servo = Actuator("servo", "elbow", "position", kp=90, kv=3, force=(-7, 7))
    both = []
    for robot in (good(), replace(good(), actuators=(servo,))):
        exported = export(robot, NO_MESHES, plan_of(export={"usd": {}}))
        text = exported.files["robot.usda"].decode()
        assert failed(checked(robot, text, tmp_path_factory.mktemp("good"), written=exported.written)) == []
        both.append((robot, text, exported.written))
    return both


@pytest.mark.parametrize("fault", [*USD, *DRIVES], ids=lambda fault: f"{fault.expects}: {fault.kind}")
def test_a_fault_fails_the_check_that_is_meant_for_it(fault, exports, tmp_path):
    robot, text, written = exports[fault in DRIVES]
    (tmp_path / "robot.usda").write_text(text)
    fault.change(tmp_path, "robot")
    names = failed(checked(robot, (tmp_path / "robot.usda").read_text(), tmp_path, written=written))
    assert names == ["drives"] if fault in DRIVES else fault.expects in names


@pytest.mark.parametrize("text", ["", "nonsense", "#usda 1.0\n"])
def test_what_cannot_be_read_is_one_failed_check(text, tmp_path):
    (only,) = checked(good(), text, tmp_path)
    assert not only.passed
    assert only.name == "robot.usda: reads"
    assert only.detail


def test_quick_only_reads(tmp_path):
    robot = good()
    (only,) = checked(robot, text_of(robot), tmp_path, quick=True)
    assert only.passed
