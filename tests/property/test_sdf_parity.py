"""Random documents: the SDF is the robot of the MJCF and of the URDF, by three readers."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.robot.model.poses import at_rest
from linkwright.stages.robot.model.robot import JointType, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate.read.sdf import check_file
from tests.fake_onshape.document import Document
from tests.fake_onshape.random_document import documents
from tests.fake_onshape.sample import sample_document
from tests.support import mjcfs
from tests.support.building import plan_of, robot_of, write
from tests.support.drawn import DYNAMICS, PLACES, SLOWLY, drawn
from tests.support.other_robots import FILES, is_here
from tests.support.robots import LOOPS, joint, loop, pose, robot_with
from tests.support.sdf_parity import Three
from tests.support.urdfs import urdf_robot

KEYS = {
    "export": {"urdf": {}, "mjcf": {}, "sdf": {}},
    "joints": DYNAMICS,
}


def agree(document: Document, root: int, seed: int) -> bool:
    """Compares; whether another pose closes the loops."""
    return compare(*drawn(document, root, seed, **KEYS), seed)


def compare(robot: Robot, plan: Plan, seed: int) -> bool:
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        made = write(robot, Path(folder), plan)
        readers = Three(robot, made.files, Path(folder))
        checks = list(check_file(Path(folder) / "robot.sdf", made.written, quick=False))
    assert [check for check in checks if check.fails] == []
    readers.agree(rng)
    return bool(robot.loops) and readers.close_again(rng)


@settings(max_examples=4, **SLOWLY)
@given(documents(everything=True), PLACES, PLACES)
def test_the_sdf_is_the_document(document: Document, root: int, seed: int) -> None:
    agree(document, root, seed)


@settings(max_examples=4, **SLOWLY)
@given(documents(everything=True, loops=True), PLACES, PLACES)
def test_the_sdf_has_the_loops_of_the_document(document: Document, root: int, seed: int) -> None:
    agree(document, root, seed)


@pytest.mark.slow
@settings(max_examples=20, **SLOWLY)
@given(st.booleans().flatmap(lambda loops: documents(everything=True, loops=loops)), PLACES, PLACES)
def test_the_sdf_is_the_document_many_times(document: Document, root: int, seed: int) -> None:
    agree(document, root, seed)


def test_the_sample_is_one_robot_in_three_files() -> None:
    plan = plan_of(**KEYS)
    assert compare(robot_of(sample_document(), plan), plan, 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "saved", "onto_root"),
    [*((kind, True, kind in ("ball", "pin_slot")) for kind in LOOPS), ("planar", False, True)],
)
def test_a_loop_of_any_type_is_closed_at_another_pose(kind: JointType, saved: bool, onto_root: bool) -> None:
    """`saved`: whether zero does not close it, so that the SDF's joints count from elsewhere; `onto_root`:
    whether the mate's first entity is on the root."""
    rng = np.random.default_rng(LOOPS.index(kind))
    rows = [
        joint("parallel", "base", "one", [0.2, -0.1, 0.3, 0.4] if saved else None, place=pose(rng)),
        joint("ball", "one", "two", [(0.8, 0.6, 0.0, 0.0)] if saved else None, place=pose(rng)),
        joint("revolute", "two", "three", [0.5] if saved else None, place=pose(rng), backwards=True),
        joint("prismatic", "three", "four", [0.1] if saved else None, place=pose(rng)),
    ]
    robot = robot_with(rows)
    held = link_poses(robot, {dof.name: dof.saved for dof in robot.dofs})["four"]
    end = joint(kind, "base", "end", [at_rest(dof.kind) for dof in joint(kind, "base", "end").dofs])
    if saved:
        values = [(0.6, 0.0, 0.8, 0.0) if dof.kind == "ball" else 0.3 for dof in end.dofs]
        end = joint(kind, "base", "end", values)
    own = {dof.name: dof.saved for dof in end.dofs}
    across, near = link_poses(robot_with([end]), own)["end"], pose(rng)
    if onto_root:
        shut = loop(kind, "base", "four", held @ near @ across, near, list(own.values()))
    else:
        shut = loop(kind, "four", "base", near, held @ near @ np.linalg.inv(across), list(own.values()))
    assert compare(replace(robot, loops=(shut,)), plan_of(export=KEYS["export"]), 3)


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_a_robot_of_others_is_one_robot_in_three_files(name: str) -> None:
    if not is_here(name):
        pytest.skip("needs the robots of others")
    kind, path = FILES[name]
    plan = plan_of(export=KEYS["export"])
    robot = urdf_robot(path.read_bytes(), plan) if kind == "urdf" else mjcfs.robot_of(path)
    compare(replace(robot, name="robot"), plan, 1)
