"""`linkwright.Robot`: poses and mass matrix against MuJoCo and Pinocchio, and how joint values are given."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.api.robot import Robot
from linkwright.pipeline.errors import LinkwrightError
from linkwright.stages.robot.codec import decode_robot, encode_robot
from linkwright.stages.robot.dynamics.inertia import TINY_INERTIAL
from linkwright.stages.robot.model.robot import Dof, Dynamics, Inertial, Joint, Limits, Link, frozen
from linkwright.stages.robot.motion.start_pose import starting_point
from tests.fake_onshape.sample import sample_document
from tests.support.building import plan_of, robot_of, write
from tests.support.engines import Mujoco, Pinocchio
from tests.support.kit import OFF, ON, TOP, Kit

TOLERANCE = 1e-9


@pytest.fixture(scope="module")
def sample():
    return Robot(robot_of(sample_document(), plan_of(name="sample")))


def all_types():
    """A chain with a joint of every type."""
    kit = Kit()
    bars = [kit.place(name) for name in "ABCDEFGH"]
    kit.root.instances[0].fixed = True
    types = ["revolute", "slider", "cylindrical", "ball", "planar", "pin_slot", "parallel"]
    for kind, below, above in zip(types, bars, bars[1:], strict=False):
        getattr(kit.root, kind)(kind.capitalize(), (above, OFF), (below, ON @ TOP))
    return kit.document


def drawn(robot, random):
    """Random values of all dofs."""
    q = {}
    for name, dof in robot.dofs.items():
        if dof.kind == "ball":
            quat = random.normal(size=4)
            q[name] = tuple(map(float, quat / np.linalg.norm(quat)))
        else:
            q[name] = float(random.uniform(-2, 2))
    return q


@pytest.mark.parametrize("document", [sample_document, all_types], ids=lambda made: made.__name__)
def test_poses_and_mass_matrix_equal_those_of_engines(tmp_path, document):
    value = decode_robot(encode_robot(robot_of(document())))
    robot = Robot(value)
    start = starting_point(value)
    exported = write(value, tmp_path)
    from_mjcf = Mujoco(tmp_path / "robot.xml", {name: start[name] for name in robot.dofs})
    from_urdf = Pinocchio(exported.files["robot.urdf"])
    random = np.random.default_rng(7)
    for q in [robot.values(), *(drawn(robot, random) for _ in range(5))]:
        ours = robot.mass_matrix(q)
        assert ours.shape == (len(robot.speeds), len(robot.speeds))
        for engine in (from_mjcf, from_urdf):
            there = engine.poses(q)
            for name, pose in robot.poses(q).items():
                np.testing.assert_allclose(pose, there[name], rtol=0, atol=TOLERANCE)
            np.testing.assert_allclose(
                engine.mass_matrix(q, list(robot.dofs)), ours, rtol=TOLERANCE, atol=TOLERANCE
            )


def test_a_body_that_moves_freely_has_six_speeds(sample):
    """As MuJoCo has them: the velocity in the world, then the turning in the body's own axes."""
    text = """<mujoco><worldbody><body name="b" pos="1 2 3"><freejoint name="b"/>
      <inertial mass="2" pos=".1 .2 .3" fullinertia="3 4 5 .1 .2 .3"/></body></worldbody></mujoco>"""
    engine = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(engine)
    quat = np.array([0.5, 0.1, -0.7, 0.5]) / np.linalg.norm([0.5, 0.1, -0.7, 0.5])
    data.qpos[:] = [0.3, -0.2, 0.9, *quat]
    mujoco.mj_forward(engine, data)
    expected = np.zeros((6, 6))
    for column, unit in zip(expected, np.eye(6), strict=True):
        mujoco.mj_mulM(engine, data, column, unit)

    inertia = frozen([[3, 0.1, 0.2], [0.1, 4, 0.3], [0.2, 0.3, 5]])
    links = (
        Link("world", TINY_INERTIAL, (), ()),
        Link("b", Inertial(2.0, frozen([0.1, 0.2, 0.3]), inertia), (), ()),
    )
    rest = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    dof = Dof("b", "free", frozen([0, 0, 0]), frozen(np.eye(4)), Limits(), Dynamics(), rest)
    joint = Joint("b", "free", "world", "b", frozen(np.eye(4)), (dof,), False, None)
    robot = Robot(replace(sample.model, links=links, joints=(joint,), relations=(), frames=(), loops=()))
    assert robot.speeds == ("b",) * 6
    np.testing.assert_allclose(robot.mass_matrix(data.qpos), expected, rtol=TOLERANCE, atol=TOLERANCE)


def test_values_come_by_name_or_in_order(sample):
    q = sample.values({"elbow": 0.3, "lift": np.float32(0.25)})
    assert (q["elbow"], q["lift"], q["shoulder"]) == (0.3, 0.25, 0.0)
    assert list(q) == list(sample.dofs)
    for values in (list(q.values()), np.array(list(q.values()))):
        assert sample.values(values) == q
    np.testing.assert_array_equal(sample.mass_matrix(q), sample.mass_matrix(list(q.values())))
    (rule,) = sample.model.relations
    expected = pytest.approx(0.2 * rule.multiplier + rule.offset)
    assert sample.values({rule.driver: 0.2})[rule.follower] == expected
    assert sample.values({rule.driver: 0.2, rule.follower: 0.1})[rule.follower] == 0.1


@pytest.mark.parametrize(("q", "message"), [
    ({"elbw": 1}, "q.elbw: the robot has no dof of this name\n  → did you mean elbow?"),
    ({"elbow": (1, 0, 0, 0)}, "q.elbow: expected 1 number, got 4"),
    ([0, 1], "q: expected 10 numbers, one after the other as in `dofs`, got 2"),
])  # fmt: skip
def test_wrong_values_are_refused(sample, q, message):
    with pytest.raises(LinkwrightError) as caught:
        sample.poses(q)
    assert str(caught.value) == message


def test_names_frames_and_totals(sample):
    assert repr(sample) == "<linkwright.Robot sample: 11 links, 10 joints, 3.286 kg>"
    assert next(iter(sample.links)) == "base_plate"
    assert sample.joints["elbow"].child == "forearm"
    assert sample.mass == pytest.approx(sum(sample.links[name].inertial.mass for name in sample.links))
    (name,) = sample.frames
    frame = sample.frames[name]
    there = sample.poses(sample.saved)[frame.link] @ frame.link_from_frame
    np.testing.assert_array_equal(sample.frame_poses(sample.saved)[name], there)
    with pytest.raises(TypeError):
        sample.links["x"] = None
