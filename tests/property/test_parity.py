"""Random documents: both exported files are the document, by three independent engines.

Ground truth is the builder's own kinematics and dynamics; Pinocchio reads the URDF and MuJoCo the
MJCF. Poses, mass matrix and gravity torque agree at random joint values, whichever link is the root
and in whatever order instances and features come.
"""

import math
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stages.robot.codec import decode_robot, encode_robot
from stages.robot.model import Robot
from stages.validate import validate
from tests.building import plan_of, robot_of, write
from tests.engines import Mujoco, Pinocchio
from tests.onshape.document import Document
from tests.onshape.random_document import documents
from tests.onshape.truth import Truth

TOLERANCE = 1e-9


def agree(document: Document, root: int, shuffle: int, seed: int) -> None:
    """Builds with the `root`-th link as root and instances shuffled; compares at three random q."""
    links = sorted(link.name for link in robot_of(document).links)
    plan = plan_of(root={"select": links[root % len(links)], "base": ["fixed", "free"][seed % 2]})
    robot = decode_robot(encode_robot(robot_of(document, plan, shuffle=shuffle)))
    with tempfile.TemporaryDirectory() as folder:
        exported = write(robot, Path(folder))
        pinocchio = Pinocchio(exported.files["robot.urdf"])
        engine = Mujoco(Path(folder) / "robot.xml")
        failed = [check for check in validate(Path(folder), robot, plan) if not check.passed]
    assert not failed
    truth = document.truth
    if robot.loops:
        # The document's own tree leaves out the same mates, so that q means the same.
        cut = {truth.joint((loop.mate.owner, loop.mate.feature)).name for loop in robot.loops}
        truth = truth.cut_at(cut)
    names = [joint.name for joint in robot.joints]
    edges = {joint.name: truth.joint((joint.mate.owner, joint.mate.feature)).name for joint in robot.joints}
    order = [[edge.name for edge in truth.tree_joints].index(edges[name]) for name in names]
    held = robot.root.parts[0].path
    random = np.random.default_rng(seed)
    for _ in range(3):
        q = {name: random.uniform(-2, 2) for name in names}
        true_q = {edges[name]: value for name, value in q.items()}
        poses = truth.poses(true_q, root=held)
        for found in (pinocchio.poses(q), engine.poses(q)):
            for link in robot.links:
                for part in link.parts:
                    same(found[link.name] @ part.link_from_part, poses[part.path])
        if not names:
            continue
        mass = truth.mass_matrix(true_q, root=held)[np.ix_(order, order)]
        gravity = truth.gravity_torque(true_q, root=held)[order]
        for tool in (pinocchio, engine):
            same(tool.mass_matrix(q, names), mass)
            same(tool.gravity(q, names), gravity)
    matches(robot, truth)


def matches(robot: Robot, truth: Truth) -> None:
    """Limits, relations and totals are the document's own."""
    for joint in robot.joints:
        edge = truth.joint((joint.mate.owner, joint.mate.feature))
        assert (joint.limits.lower, joint.limits.upper) == tuple(edge.limits)
        off = joint.saved - truth.saved[edge.name]
        # By whole turns a saved value is taken into the limits, where CAD's pose is beside them.
        assert abs(math.remainder(off, math.tau) if joint.type == "revolute" else off) < TOLERANCE
    by_follower = {relation.follower: relation for relation in robot.relations}
    edges = {truth.joint((j.mate.owner, j.mate.feature)).name: j.name for j in robot.joints}
    for gear in truth.relations:
        relation = by_follower[edges[gear.follower]]
        assert relation.driver == edges[gear.driver]
        assert relation.offset == 0.0
        assert abs(relation.multiplier - gear.multiplier) < TOLERANCE
    total = truth.total_mass()
    assert abs(sum(link.inertial.mass for link in robot.links) - total) < TOLERANCE * total
    for loop in robot.loops:
        assert loop.residual < TOLERANCE


def same(found: np.ndarray, expected: np.ndarray) -> None:
    """Equal to 1e-9 on the scale of the larger of 1 and the largest entry."""
    scale = max(1.0, float(np.abs(expected).max()))
    assert np.abs(found - expected).max() < TOLERANCE * scale


places = st.integers(0, 1000)
slowly = {"suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large]}


@settings(max_examples=60, **slowly)
@given(documents(), places, places, places)
def test_both_files_are_the_document(document: Document, root: int, shuffle: int, seed: int) -> None:
    agree(document, root, shuffle, seed)


@pytest.mark.slow
@settings(max_examples=500, **slowly)
@given(st.booleans().flatmap(lambda loops: documents(loops=loops)), places, places, places)
def test_both_files_are_the_document_many_times(
    document: Document, root: int, shuffle: int, seed: int
) -> None:
    agree(document, root, shuffle, seed)


@settings(max_examples=40, **slowly)
@given(documents(loops=True), places, places, places)
def test_loops_change_nothing_about_the_tree(document: Document, root: int, shuffle: int, seed: int) -> None:
    agree(document, root, shuffle, seed)


@settings(max_examples=20, **slowly)
@given(documents(loops=True), places, places)
def test_neither_root_nor_order_changes_what_is_cut_or_named(
    document: Document, root: int, shuffle: int
) -> None:
    first = robot_of(document)
    links = sorted(link.name for link in first.links)
    plan = plan_of(root={"select": links[root % len(links)]})
    second = robot_of(document, plan, shuffle=shuffle)
    assert {link.name for link in second.links} == set(links)
    assert {j.name: (j.limits, j.type) for j in second.joints} == {
        j.name: (j.limits, j.type) for j in first.joints
    }
    assert [loop.name for loop in second.loops] == [loop.name for loop in first.loops]
