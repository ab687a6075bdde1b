"""Robots stand with their lowest collider on the ground, and the controls of keyframes hold the poses."""

import math
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import mujoco
import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.optimize import linprog

from linkwright.stages.export.ground.footing import ground_supports, weight_shares
from linkwright.stages.export.ground.standing import stand
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Dynamics, Keyframe, Limits, Primitive, frozen
from linkwright.stages.robot.motion.start_pose import keyframes
from tests.support.building import NO_MESHES, plan_of, write
from tests.support.drawn import each
from tests.support.exports import compiled, exported
from tests.support.pendulums import ARM, GRAVITY, MASS, at_home, lump, pendulum
from tests.support.robots import at, joint, robot_with
from tests.support.states import state
from tests.support.touching import NO_FILES, ball, box, no_memo

TURN = st.floats(-3.0, 3.0)


def geometry_of(robot, **mesh):
    return make_geometry(robot, NO_FILES, plan_of(mesh=mesh), no_memo)


def legged(fixed=True):
    """A box on one leg that points down and to the side, with a ball of a foot; saved and limited so that at
    home the hip is at 0.5 rad."""
    hip = joint("revolute", "base", "leg", name="hip", saved=[0.2], limits={"hip": Limits(0.5, 1.0)})
    shapes = {"base": (box(0.2, 0.1, 0.06),), "leg": (ball(0.02, at(0.3, 0.0, -0.25)),)}
    return robot_with([hip], shapes=shapes, fixed=fixed)


def scene_of(robot, folder, **keys):
    """The compiled scene of a robot of primitives."""
    write(robot, folder, plan_of(**keys), geometry_of(robot))
    return mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))


def standing(robot, **keys):
    return stand(robot, geometry_of(robot, **keys.get("mesh", {})), plan_of(**keys))


SIZES = {"box": (0.1, 0.2, 0.3), "sphere": (0.1,), "cylinder": (0.1, 0.3), "capsule": (0.1, 0.3)}


@pytest.mark.parametrize("count", [15, pytest.param(60, marks=pytest.mark.slow)])
def test_primitive_in_any_pose_touches_the_ground(count):
    def touches(kind, rpy):
        pose = frozen(from_parts(rotation_from_rpy(rpy), np.array([0.1, -0.2, 0.3])))
        robot = robot_with(shapes={"base": (Primitive(kind, SIZES[kind], pose),)}, fixed=False)
        with TemporaryDirectory() as folder:
            model = scene_of(robot, Path(folder), export={"mjcf": {}})
        floor = model.geom("floor").id
        (collider,) = [geom for geom in range(model.ngeom) if model.geom_contype[geom] and geom != floor]
        apart = mujoco.mj_geomDistance(model, state(model), collider, floor, 1.0, np.zeros(6))
        assert abs(apart) < 1e-6
        assert standing(robot).low[2] == pytest.approx(0.0, abs=1e-8)

    each(touches, count, st.sampled_from([*SIZES]), st.tuples(TURN, TURN, TURN))


def test_free_robot_stands_on_its_lowest_collider_at_home(tmp_path):
    model = scene_of(legged(fixed=False), tmp_path)
    data = state(model, "home")
    # The foot turns about z with the hip, so its height is that in the leg's frame.
    assert data.qpos[2] == pytest.approx(0.27, abs=1e-9)
    foot = next(g for g in range(model.ngeom) if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_SPHERE)
    assert data.geom_xpos[foot][[2, 0]] == pytest.approx([0.02, 0.3 * math.cos(0.5)], abs=1e-9)


def bending():
    """The robot whose hip swings its leg up, saved with a straight leg, at home and in a pose of its own with
    a bent one."""
    upright = from_parts(rotation_from_rpy((math.pi / 2, 0.0, 0.0)), np.zeros(3))
    hip = joint("revolute", "base", "leg", name="hip", place=upright)
    robot = robot_with([hip], shapes={"leg": (ball(0.02, at(0.0, -0.25, 0.0)),)}, fixed=False)
    named = tuple(Keyframe(name, (("hip", value),)) for name, value in (("home", 0.4), ("tuck", 1.2)))
    return replace(robot, keyframes=named)


def test_free_robot_touches_the_ground_in_all_keyframes(tmp_path):
    model = scene_of(bending(), tmp_path)
    heights = {model.key(index).name: float(model.key_qpos[index][2]) for index in range(model.nkey)}
    bent = {"home": 0.4, "tuck": 1.2, "cad": 0.0}
    expected = {name: pytest.approx(0.25 * math.cos(hip) + 0.02, abs=1e-8) for name, hip in bent.items()}
    assert (heights, float(model.qpos0[2])) == (expected, expected["cad"])


def test_sdf_at_zero_touches_the_ground():
    robot = bending()
    text = exported(robot, geometry_of(robot), export={"sdf": {}}).files["robot.sdf"].decode()
    assert float(text.partition("<pose>")[2].split()[2]) == pytest.approx(0.27, abs=1e-8)


def test_fixed_robot_stands_on_its_fixed_links():
    placed = standing(legged())
    assert placed.world_from_root[2, 3] == pytest.approx(0.03, abs=1e-9)
    (diagnostic,) = placed.diagnostics
    assert (diagnostic.code, diagnostic.where) == ("W-GROUND", "leg")
    assert "240 mm in the ground" in diagnostic.message
    seen = standing(legged(), mesh={"collider": "visual"})
    assert seen.world_from_root[2, 3] == pytest.approx(0.03, abs=1e-9), (
        "without colliders what is seen stands"
    )


@pytest.mark.parametrize("off", [0.0019, -0.0019, 0.0021, -0.0021])
def test_fixed_robot_stays_within_the_slack_of_a_collider(off):
    shapes = {"base": (box(0.2, 0.1, 0.06, at(0.0, 0.0, 0.03 - off)),)}
    for fixed in (True, False):
        height = standing(robot_with(shapes=shapes, fixed=fixed)).world_from_root[2, 3]
        assert height == pytest.approx(0.0 if fixed and abs(off) < 0.002 else off, abs=1e-9)


@pytest.mark.parametrize("tilt", [0.3, -0.8])
def test_robot_on_a_slope_moves_along_the_vertical(tilt):
    robot = robot_with(shapes={"base": (ball(0.1, at(0.4, 0.0, 0.0)),)}, fixed=False)
    placed = standing(robot, ground={"xyz": [0, 0, -0.2], "rpy": [0, tilt, 0]})
    height = -0.2 - 0.4 * math.tan(tilt) + 0.1 / math.cos(tilt)
    assert placed.world_from_root[:3, 3] == pytest.approx([0.0, 0.0, height], abs=1e-8)


def test_wall_is_no_ground():
    with pytest.raises(ExportError, match="too steep") as caught:
        standing(legged(fixed=False), ground={"rpy": [0, 1.55, 0]})
    assert caught.value.where == "scene.pose"


@pytest.mark.parametrize("keys", [{"ground": {"kind": "none"}}, {"scene": {"pose": {"xyz": [0, 0, 0]}}}])
def test_robot_without_a_ground_or_with_a_pose_stays(keys):
    placed = standing(legged(fixed=False), **keys)
    np.testing.assert_array_equal(placed.world_from_root, np.eye(4))
    np.testing.assert_array_equal(placed.placed({"hip": 1.0}), np.eye(4))
    diagnostics = [diagnostic.where for diagnostic in placed.diagnostics]
    assert diagnostics == ([] if "ground" in keys else ["base", "leg"])


def test_robot_without_shapes_stays():
    placed = stand(legged(fixed=False), NO_MESHES, plan_of())
    np.testing.assert_array_equal(placed.world_from_root, np.eye(4))
    assert not np.isfinite(placed.low).any()


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
    model, geometry, ground = scene_of(robot, tmp_path, **keys), geometry_of(robot), plan_of().ground
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    placed = standing(robot, **keys).placed
    for name, pose in keyframes(robot).items():
        data, place = state(model, name), placed(pose)
        feet = ground_supports(robot, geometry, place, ground, pose, UP)
        assert len(feet) == 4
        left = data.qfrc_bias - data.qfrc_actuator
        for support in feet:
            point, body = (place @ np.append(support.point, 1.0))[:3], model.body(support.link).id
            force = np.array([0, 0, support.mass * GRAVITY])
            mujoco.mj_applyFT(model, data, force, np.zeros(3), point, body, data.qfrc_applied)
        assert np.abs(left - data.qfrc_applied).max() < 1e-9
        assert np.abs(left[:6]).max() > 1.0


def test_ground_does_not_carry_compensated_weight(tmp_path):
    servos = {"*": "position", "*_hip": {"gravcomp": 1}}
    model = scene_of(dog(), tmp_path, actuators=servos)
    home, data = model.key("home").qpos, at_home(model, 10.0)
    assert np.abs(data.qpos[7:] - home[7:]).max() < 2e-3


@pytest.mark.parametrize(("ahead", "keys"), [
    (0.0, {"ground": {"kind": "none"}}), (0.0, {"scene": {"pose": {"xyz": [0, 0, 2.0]}}}), (0.6, {}),
], ids=["no ground", "in the air", "it would fall"])  # fmt: skip
def test_robot_that_stands_nowhere_has_its_targets_at_the_pose(tmp_path, ahead, keys):
    key = scene_of(dog(ahead), tmp_path, actuators={"*": "position"}, **keys).key("home")
    assert key.ctrl == pytest.approx(key.qpos[7:], abs=1e-12)


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
    assert weight_shares(SQUARE, np.array([*centre, 0.7]), UP) == pytest.approx(shares, abs=1e-6)


NUMBERS = st.floats(-1.0, 1.0).map(lambda value: round(value, 2))


@pytest.mark.parametrize("count", [40, pytest.param(150, marks=pytest.mark.slow)])
def test_weight_is_balanced_where_forces_that_push_can_do_it(count):
    """Against a linear program; and of all shares that balance, none has a smaller sum of squares."""

    def balances(points, centre, up):
        direction, middle = np.array([*up, 2.0]), np.array([*centre, 0.5])
        places = np.array([[*point, 0.1 * index] for index, point in enumerate(points)])
        shares = weight_shares(places, middle, direction)
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

    pair = st.tuples(NUMBERS, NUMBERS)
    each(balances, count, st.lists(pair, min_size=1, max_size=8), pair, pair)


def is_on_the_edge(flat):
    """Whether a weight is so near the edge of its points that rounding decides."""
    angles = np.linspace(0, 2 * np.pi, 3600)
    basis = np.linalg.svd(flat, full_matrices=True)[2][:2]
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1) @ basis
    return bool((flat @ along.T).max(axis=0).min() < 1e-3)
