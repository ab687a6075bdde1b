"""The SDF is read back: a good one passes every check, every fault planted in one fails the check for it."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.formats.sdf.elements import SdfError
from linkwright.stages.formats.sdf.parse import parse_sdf
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Relation, Robot, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.support.building import plan_of, write
from tests.support.checked import checked
from tests.support.faults.checks import SDF, UNREADABLE_SDF
from tests.support.faults.edits import sub
from tests.support.faults.fault import Fault, table
from tests.support.robots import EVERY, LOOPS, at, joint, loop, pose, robot_with

PLAN = plan_of(export={"sdf": {}})


def looped(kind: str = "revolute") -> Robot:
    """A robot whose loop is closed at its saved pose, not at zero, with a gear and a frame beside it."""
    rng = np.random.default_rng(5)
    limits = {"one_joint": Limits(-1, 2)}
    rows = [
        joint("revolute", "base", "one", [0.5], limits=limits, dynamics=Dynamics(0.1, 0.2, None, 3, 4)),
        joint("ball", "one", "two", [(0.8, 0.6, 0.0, 0.0)], place=pose(rng)),
        joint("cylindrical", "base", "three", [0.1, 0.3], place=pose(rng)),
        joint("revolute", "base", "gear", [1.5], place=at(0, 1, 0), limits={"gear_joint": Limits(None, 4)}),
    ]
    gear = Relation("Gear", "gear_joint", "one_joint", 2.0, 0.5)
    robot = robot_with(rows, relations=[gear], frames=[Frame("tip", "two", frozen(at(0, 0, 0.1)), "Tip")])
    poses = link_poses(robot, {dof.name: dof.saved for dof in robot.dofs})
    near = pose(rng)
    own = [0.2 * (index + 1) for index in range(len(loop(kind, "two", "base", near, near).dofs))]
    values = [(0.6, 0.0, 0.8, 0.0)] if kind == "ball" else own
    end = joint(kind, "base", "end", values)
    across = link_poses(robot_with([end]), {dof.name: dof.saved for dof in end.dofs})["end"]
    shut = loop(kind, "two", "base", near, poses["two"] @ near @ np.linalg.inv(across), values, name="shut")
    return replace(robot, loops=(shut,))


def checks(robot: Robot, folder: Path, fault: Fault | None = None) -> dict[str, bool]:
    """Whether the checks of the SDF pass, with a fault in its text."""
    write(robot, folder, PLAN)
    if fault is not None:
        fault.change(folder, "robot")
    outcomes = [check for check in checked(folder, robot, PLAN) if check.name.startswith("robot.sdf: ")]
    return {check.name.removeprefix("robot.sdf: "): check.passed for check in outcomes}


@pytest.mark.parametrize("fixed", [True, False])
@pytest.mark.parametrize("kind", EVERY)
def test_every_joint_passes_every_check(kind, fixed, tmp_path):
    rng = np.random.default_rng(EVERY.index(kind))
    saved = [(0.1, 0.2, 0.3, 0.8, 0.6, 0.0, 0.0)] if kind == "free" else None
    origins = [pose(rng) for _ in range(3)]
    rows = [joint(kind, "base", "one", saved, place=pose(rng), backwards=fixed, origins=origins)]
    rows.append(joint("prismatic", "one", "two", place=pose(rng), mirrored=True))
    outcomes = checks(robot_with(rows, fixed=fixed), tmp_path)
    assert len(outcomes) == 11
    assert all(outcomes.values()), outcomes


@pytest.mark.parametrize("folder", ["", "model://robot/"])
def test_a_mesh_that_is_not_there_is_found(folder, tmp_path):
    mesh = f"<mesh><uri>{folder}assets/one.stl</uri></mesh>"
    visual = f'<visual name="lost"><geometry>{mesh}</geometry></visual>'
    (fault,) = table("sdf", ("a mesh", sub("</link>", f"{visual}</link>"), "meshes"))
    robot = robot_with([joint("revolute", "base", "one")])
    assert not checks(robot, tmp_path, fault)["meshes"]
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets/one.stl").touch()
    assert checks(robot, tmp_path, fault)["meshes"]


@pytest.mark.parametrize("kind", LOOPS)
def test_every_loop_passes_every_check(kind, tmp_path):
    outcomes = checks(looped(kind), tmp_path)
    assert outcomes.pop("loops")
    assert all(outcomes.values()), outcomes


def test_a_loop_that_begins_on_the_root_passes_every_check(tmp_path):
    for kind in ("ball", "pin_slot"):
        robot = looped(kind)
        (loop,) = robot.loops
        end = joint(kind, "base", "end", [dof.saved for dof in loop.dofs])
        across = link_poses(robot_with([end]), {dof.name: dof.saved for dof in end.dofs})["end"]
        # Of the same values, seen from the other side.
        turned = replace(
            loop,
            link_a="base",
            link_b="two",
            a_from_frame=frozen(loop.b_from_frame @ across @ across),
            b_from_frame=frozen(loop.a_from_frame),
        )
        outcomes = checks(replace(robot, loops=(turned,)), tmp_path)
        assert all(outcomes.values()), outcomes


@pytest.mark.parametrize("fault", SDF, ids=lambda fault: fault.kind)
def test_a_fault_fails_the_check_that_is_meant_for_it(fault, tmp_path):
    outcomes = checks(looped(), tmp_path, fault)
    assert outcomes["reads"]
    assert not outcomes[fault.expects], outcomes


@pytest.mark.parametrize("fault", UNREADABLE_SDF, ids=lambda fault: fault.kind)
def test_what_cannot_be_read_is_one_failed_check_that_says_why(fault, tmp_path):
    assert checks(looped(), tmp_path, fault) == {"reads": False}
    with pytest.raises(SdfError, match=re.escape(fault.expects)):
        parse_sdf((tmp_path / "robot.sdf").read_bytes())


def test_quick_only_reads_it(tmp_path):
    robot = looped()
    write(robot, tmp_path, PLAN)
    quick = plan_of(export={"sdf": {}}, validate={"level": "quick"})
    names = [check.name for check in checked(tmp_path, robot, quick)]
    assert names == ["model.config: names", "robot.sdf: reads"]
