"""The controls of keyframes hold the poses, also of legs that stand on the ground: by MuJoCo, which knows
nothing of how they were found, and by closed forms."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from linkwright.stages.export.ground.footing import balanced, supports
from linkwright.stages.export.ground.standing import stand
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Dynamics, Keyframe, Limits
from linkwright.stages.robot.motion.start_pose import keyframes
from tests.support.building import plan_of, write
from tests.support.exports import compiled, exported, failing
from tests.support.pendulums import ARM, GRAVITY, MASS, at_home, lump, pendulum
from tests.support.robots import at, joint, robot_with
from tests.support.states import run, state
from tests.support.touching import ball, box
from tests.unit.export.test_standing import geometry_of, scene_of

UP = np.array([0.0, 0.0, GRAVITY])

THIGH, SHANK, BEND = 0.2, 0.2, 0.6

LEGS = {"fl": (1, 1), "fr": (1, -1), "rl": (-1, 1), "rr": (-1, -1)}


def dog(ahead=0.0, effort=None):
    """A body of 8 kg, its mass this far `ahead`, on four legs of two turns with balls for feet."""
    joints, shapes, masses = [], {"base": (box(0.4, 0.2, 0.1),)}, {"base": lump(8.0, ahead, 0.01, 0.02)}
    for leg, (x, y) in LEGS.items():
        thigh, shank = f"{leg}_thigh", f"{leg}_shank"
        limits = {f"{leg}_hip": Limits(-1.2, 1.2), f"{leg}_knee": Limits(-2.4, -0.1)}
        more = {"limits": limits, "dynamics": Dynamics(effort=effort)}
        hip = at(0.2 * x, 0.1 * y, 0) @ from_parts(rotation_from_rpy((-math.pi / 2, 0, 0)), np.zeros(3))
        joints.append(joint("revolute", "base", thigh, [BEND], name=f"{leg}_hip", place=hip, **more))
        knee = {"name": f"{leg}_knee", "place": at(0, THIGH, 0), **more}
        joints.append(joint("revolute", thigh, shank, [-2 * BEND], **knee))
        shapes[shank] = (ball(0.02, at(0, SHANK, 0)),)
        masses |= {thigh: lump(0.6, 0, 0.1, 0), shank: lump(0.2, 0, 0.1, 0)}
    return robot_with(joints, inertials=masses, shapes=shapes, fixed=False)


@pytest.mark.parametrize("ahead", [0.0, 0.1])
@pytest.mark.parametrize("effort", [None, 30.0])
def test_robot_on_four_legs_stands_as_it_is_at_home(tmp_path, ahead, effort):
    model = scene_of(dog(ahead, effort), tmp_path, actuators={"*": "position"})
    home, data = model.key("home").qpos, at_home(model, 10.0)
    assert np.abs(data.qpos[7:] - home[7:]).max() < 2e-3
    assert np.linalg.norm(data.qpos[:3] - home[:3]) < 2e-3
    assert np.abs(data.qvel).max() < 1e-3


@pytest.mark.parametrize("ahead", [0.0, 0.1])
def test_joints_and_ground_balance_the_whole_robot(tmp_path, ahead):
    """M·0 + bias = actuators + Jᵀ · the forces of the ground, for the floating base too."""
    robot, keys = dog(ahead), {"actuators": {"*": "position"}}
    model, geometry, plan = scene_of(robot, tmp_path, **keys), geometry_of(robot), plan_of(**keys)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    standing = stand(robot, geometry, plan)
    for name, pose in keyframes(robot).items():
        data, place = state(model, name), standing.placed(pose)
        feet = supports(robot, geometry, place, plan.ground, pose, UP)
        assert len(feet) == 4
        left = data.qfrc_bias - data.qfrc_actuator
        for support in feet:
            point, body = (place @ np.append(support.point, 1.0))[:3], model.body(support.link).id
            force = np.array([0, 0, support.mass * GRAVITY])
            mujoco.mj_applyFT(model, data, force, np.zeros(3), point, body, data.qfrc_applied)
        assert np.abs(left - data.qfrc_applied).max() < 1e-9
        assert np.abs(left[:6]).max() > 1.0


@pytest.mark.parametrize(("ahead", "keys"), [
    (0.0, {"ground": {"kind": "none"}}), (0.0, {"scene": {"pose": {"xyz": [0, 0, 2.0]}}}), (0.6, {}),
], ids=["no ground", "in the air", "it would fall"])  # fmt: skip
def test_robot_that_stands_nowhere_has_its_targets_at_the_pose(tmp_path, ahead, keys):
    key = scene_of(dog(ahead), tmp_path, actuators={"*": "position"}, **keys).key("home")
    assert key.ctrl == pytest.approx(key.qpos[7:], abs=1e-12)


def test_each_keyframe_is_held_with_soft_servos(tmp_path):
    robot = replace(pendulum(saved=0.4), keyframes=(Keyframe("up", (("arm_joint", -0.7),)),))
    for kind in ("position", "intvelocity", "motor"):
        entry = {"type": kind} if kind == "motor" else {"type": kind, "kp": 60, "kv": 8}
        model = compiled(exported(robot, actuators={"*": entry}))
        for key in range(model.nkey):
            data = run(model, state(model, key), 0.002 if kind == "motor" else 4.0)
            assert data.qpos[0] == pytest.approx(model.key(key).qpos[0], abs=1e-9)
    plan = plan_of(actuators={"*": {"type": "position", "kp": 60}})
    assert failing(tmp_path, write(robot, tmp_path, plan), plan) == []


def test_control_range_includes_the_target_that_holds_home():
    """The weight pulls the arm down, from the upper end of its range."""
    model = compiled(exported(pendulum(saved=1.0, effort=12.0), actuators={"*": "position"}))
    sag = MASS * GRAVITY * ARM * math.cos(1.0) / 120.0
    assert model.actuator("arm_joint").ctrlrange == pytest.approx([-1.0, 1.0 + sag], rel=1e-6)
    assert at_home(model, 3.0).qpos[0] == pytest.approx(1.0, abs=1e-6)
    entry = {"type": "position", "ctrlrange": [-1, 1]}
    given_range = compiled(exported(pendulum(saved=1.0, effort=12.0), actuators={"*": entry}))
    assert given_range.actuator("arm_joint").ctrlrange == pytest.approx([-1.0, 1.0])


SQUARE = np.array([[1.0, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]])


@pytest.mark.parametrize(("centre", "shares"), [
    ((0, 0), [0.25, 0.25, 0.25, 0.25]),
    ((1, 1), [1, 0, 0, 0]),
    ((0.5, 0), [0.375, 0.375, 0.125, 0.125]),
    ((0, 1), [0.5, 0, 0.5, 0]),
    ((1.01, 0), [0, 0, 0, 0]),
])  # fmt: skip
def test_four_points_share_a_weight(centre, shares):
    assert balanced(SQUARE, np.array([*centre, 0.7]), UP) == pytest.approx(shares, abs=1e-6)


NUMBERS = st.floats(-1.0, 1.0).map(lambda value: round(value, 2))


@settings(max_examples=150)
@given(
    points=st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=8),
    centre=st.tuples(NUMBERS, NUMBERS),
    up=st.tuples(NUMBERS, NUMBERS),
)
def test_weight_is_balanced_where_forces_that_push_can_do_it(points, centre, up):
    """Against a linear program; and of all shares that balance, none has a smaller sum of squares."""
    direction, middle = np.array([*up, 2.0]), np.array([*centre, 0.5])
    places = np.array([[*point, 0.1 * index] for index, point in enumerate(points)])
    shares = balanced(places, middle, direction)
    unit = direction / np.linalg.norm(direction)
    flat = (np.eye(3) - np.outer(unit, unit)) @ (places - middle).T
    rows, wanted, slack = np.vstack([np.ones(len(points)), flat]), np.array([1.0, 0, 0, 0]), np.eye(4)
    costs = np.concatenate([np.zeros(len(points)), np.ones(8)])
    nearest = linprog(costs, A_eq=np.hstack([rows, slack, -slack]), b_eq=wanted)
    if nearest.fun > 1e-4:
        assert not shares.any()
    elif shares.any():
        assert rows @ shares == pytest.approx(wanted, abs=1e-4)
        assert shares.min() >= 0
        assert shares @ shares <= nearest.x[: len(points)] @ nearest.x[: len(points)] + 1e-4
    else:
        assert nearest.fun > 1e-9 or is_on_the_edge(flat.T)


def is_on_the_edge(flat):
    """Whether a weight is so near the edge of its points that rounding decides."""
    angles = np.linspace(0, 2 * np.pi, 3600)
    basis = np.linalg.svd(flat, full_matrices=True)[2][:2]
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1) @ basis
    return bool((flat @ along.T).max(axis=0).min() < 1e-3)
