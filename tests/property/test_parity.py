"""Random documents: both exported files are the document, by three independent engines.

Ground truth is the builder's own kinematics and dynamics; Pinocchio reads the URDF and MuJoCo the
MJCF. Poses, mass matrix (the robot's own too) and gravity torque agree at random joint values, whichever
link is the root and in whatever order instances and features come.
"""

import math
import tempfile
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import assume
from hypothesis import strategies as st

from linkwright.stages.export import export
from linkwright.stages.graph.dofs import conjugate
from linkwright.stages.robot.codec import decode_robot, encode_robot
from linkwright.stages.robot.dynamics.mass_matrix import mass_matrix
from linkwright.stages.robot.motion.start_pose import starting_point
from linkwright.stages.validate import validate
from tests.fake_onshape.copies import within
from tests.fake_onshape.random_document import documents
from tests.support.building import NO_MESHES, plan_of, robot_of, write
from tests.support.drawn import any_document, each
from tests.support.engines import Mujoco, Pinocchio
from tests.support.exports import compiled
from tests.support.parity import same
from tests.support.robots import some_values

pytestmark = pytest.mark.e2e

TOLERANCE = 1e-9


def agree(document, root, shuffle, seed, api):
    """Builds with the `root`-th link as root and instances shuffled; compares at three random q.

    `api`: the newest version that the server knows, on which it depends where limits are read.
    """
    assume(not is_undecided(document.truth))
    first = robot_of(document)
    links = ["world"] if first.root.name == "world" else sorted(link.name for link in first.links)
    base = "fixed" if links == ["world"] else ["fixed", "free"][seed % 2]
    plan = plan_of(root={"select": links[root % len(links)], "base": base})
    robot = decode_robot(encode_robot(robot_of(document, plan, shuffle=shuffle, newest=api)))
    start = starting_point(robot)
    with tempfile.TemporaryDirectory() as folder:
        exported = write(robot, Path(folder))
        pinocchio = Pinocchio(exported.files["robot.urdf"])
        engine = Mujoco(Path(folder) / "robot.xml", {d.name: start[d.name] for d in robot.dofs})
        checks = validate(Path(folder), exported.written, plan)
    assert not [check for check in checks if check.fails]
    truth = as_cut(document.truth, robot)
    names = [dof.name for dof in robot.dofs]
    edges = true_names(robot.joints, truth)
    order = truth.indices([edges[name] for name in names])
    held = robot.root.parts[0].path if robot.root.parts else ()
    random = np.random.default_rng(seed)
    for _ in range(3):
        q = some_values(robot, random)
        true_q = {edges[name]: value for name, value in in_mates(robot, q).items()}
        poses = truth.poses(true_q, root=held)
        for placed in (pinocchio.poses(q), engine.poses(q)):
            for link in robot.links:
                for part in link.parts:
                    same(placed[link.name] @ part.link_from_part, poses[part.path])
        if not names:
            continue
        mass = truth.mass_matrix(true_q, root=held)[np.ix_(order, order)]
        gravity = truth.gravity_torque(true_q, root=held)[order]
        same(mass_matrix(robot, q), mass)
        for tool in (pinocchio, engine):
            same(tool.mass_matrix(q, names), mass)
            same(tool.gravity(q, names), gravity)
    matches(robot, truth)


def is_undecided(truth):
    """Whether a mate is between the seeds of two patterns.

    No recording shows whether Onshape has it for each pair of their copies, too: the documents' own
    kinematics say so, and the product has one for each copy.
    """
    edges = {edge.name: edge for edge in (*truth.tree.edges, *truth.tree.redundant)}
    for edge in edges.values():
        before = edges.get(edge.name.rpartition(" [")[0])
        if len(edge.copies) < 2 or before is None:
            continue
        earlier, later = (
            [mate.owner + tuple(path.split("/")) for path in mate.onto] for mate in (before, edge)
        )
        ends = edge.first, edge.second
        if any(within(end, earlier) and not within(end, later) for end in ends):
            return True
    return False


def as_cut(truth, robot):
    """The document's own tree, without the mates that the robot's leaves out: so q means the same.

    Of mates that say the same, which one the robot keeps is its own choice; how many is not.
    """
    loops = {truth.joint(loop.mate.key).name for loop in robot.loops}
    kept = {truth.joint(joint.mate.key).name for joint in robot.joints}
    said_twice = {edge.name for edge in (*truth.joints, *truth.redundant) if edge.moves} - kept - loops
    assert len(said_twice) == len([edge for edge in truth.redundant if edge.moves])
    return truth.cut_at(loops, redundant=said_twice)


def true_names(joints, truth):
    """The document's own name of each dof of the robot's."""
    names = {}
    for joint in joints:
        edge = truth.joint(joint.mate.key)
        for dof in joint.dofs:
            names[dof.name] = edge.name + dof.name.removeprefix(joint.name)
    return names


def in_mates(robot, q):
    """The mates' own values: a ball's is the other way round where the chain runs backwards."""
    turned = {d.name for joint in robot.joints if joint.backwards for d in joint.dofs if d.kind == "ball"}
    return {name: conjugate(value) if name in turned else value for name, value in q.items()}


def matches(robot, truth):
    """Limits, relations and totals are the document's own."""
    edges = true_names(robot.joints, truth)
    true_dofs = {dof.name: dof for dof in truth.dofs}
    doubled = {frozenset((edge.first, edge.second)) for edge in truth.redundant}
    saved = in_mates(robot, {dof.name: dof.saved for dof in robot.dofs})
    for joint in robot.joints:
        edge = truth.joint(joint.mate.key)
        for dof in joint.dofs:
            expected = true_dofs[edges[dof.name]]
            if frozenset((edge.first, edge.second)) not in doubled:
                assert (dof.limits.lower, dof.limits.upper) == tuple(expected.limits)
            if dof.kind == "ball":
                assert abs(abs(np.dot(saved[dof.name], expected.value)) - 1) < TOLERANCE
                continue
            off = dof.saved - expected.value
            # By whole turns a saved value is taken into the limits, where CAD's pose is beside them.
            assert abs(math.remainder(off, math.tau) if dof.kind == "turn" else off) < TOLERANCE
    related(robot, truth, edges)
    total = truth.total_mass()
    assert abs(sum(link.inertial.mass for link in robot.links) - total) < TOLERANCE * total
    for loop in robot.loops:
        assert loop.residual < TOLERANCE


def related(robot, truth, edges):
    """Whatever drives, followers are where the document's own relations have them."""
    random = np.random.default_rng(len(edges))
    saved = {dof.name: dof.saved for dof in robot.dofs if dof.kind != "ball"}
    values = {name: float(random.uniform(-1, 1)) for name in saved}
    for relation in robot.relations:
        for q in (values, saved):
            driven = relation.multiplier * q[relation.driver] + relation.offset
            # In the saved pose it holds as it is; elsewhere the follower goes where it is driven.
            assert q is values or abs(driven - q[relation.follower]) < TOLERANCE * max(1.0, abs(driven))
            q[relation.follower] = driven
    moved = {true: values[name] - saved[name] for name, true in edges.items() if name in values}
    relations = [
        relation for relation in truth.relations if {relation.driver, relation.follower} <= set(moved)
    ]
    for relation in relations:
        expected = relation.multiplier * moved[relation.driver]
        assert abs(moved[relation.follower] - expected) < TOLERANCE * max(1.0, abs(expected))
    if not any(relation.offset for relation in relations):
        assert [relation.offset for relation in robot.relations] == [0.0] * len(relations)
    assert len(robot.relations) == len(relations)


places = st.integers(0, 1000)
versions = st.sampled_from([16, 17])
slow = pytest.mark.slow


@pytest.mark.parametrize(
    ("everything", "loops", "count"),
    [
        (False, False, 12),
        (True, False, 8),
        pytest.param(False, True, 25, marks=slow),
        pytest.param(True, None, 60, marks=slow),
    ],
)
def test_both_files_are_the_document(everything, loops, count):
    each(agree, count, any_document(everything, loops), places, places, places, versions)


def changes_nothing(document, root, shuffle):
    first = robot_of(document)
    links = ["world"] if first.root.name == "world" else sorted(link.name for link in first.links)
    plan = plan_of(root={"select": links[root % len(links)]})
    second = robot_of(document, plan, shuffle=shuffle)
    assert {link.name for link in second.links} == {link.name for link in first.links}
    assert facts(second) == facts(first)


def test_root_and_order_change_no_cut_and_no_name():
    each(changes_nothing, 25, documents(everything=True, loops=True), places, places)


def facts(robot):
    """What neither the root nor an order may change."""
    return {
        "joints": {joint.name: joint.type for joint in robot.joints},
        "dofs": {dof.name: (dof.limits, dof.dynamics) for dof in robot.dofs},
        "loops": {loop.name: (loop.type, loop.link_a, loop.link_b) for loop in robot.loops},
        "relations": set(robot.relations),
        "masses": {link.name: link.inertial.mass for link in robot.links},
        "parts": {link.name: [part.path for part in link.parts] for link in robot.links},
        "mobility": robot.mobility,
    }


SECONDS, OPEN = 2.0, 1e-3


def holds(document, timestep):
    """As built, without actuators: no warning, no NaN, no two sites of a loop apart."""
    plan = plan_of(scene={"option": {"timestep": timestep}})
    robot = robot_of(document, plan)
    assume(robot.loops)
    model = compiled(export(robot, NO_MESHES, plan))
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    closing = model.eq_type != mujoco.mjtEq.mjEQ_JOINT
    first, second = model.eq_obj1id[closing], model.eq_obj2id[closing]
    for _ in range(round(SECONDS / timestep)):
        mujoco.mj_step1(model, data)
        apart = np.linalg.norm(data.site_xpos[first] - data.site_xpos[second], axis=1)
        assert apart.max(initial=0.0) <= OPEN
        mujoco.mj_step2(model, data)
        assert not data.warning.number.any()
    assert np.isfinite(data.qpos).all()


@pytest.mark.parametrize(
    ("everything", "timesteps", "count"),
    [(False, [0.002, 0.005], 6), pytest.param(None, [0.001, 0.002, 0.005], 40, marks=pytest.mark.slow)],
)
def test_looped_documents_hold(everything, timesteps, count):
    each(holds, count, any_document(everything, True), st.sampled_from(timesteps))
