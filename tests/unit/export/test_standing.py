"""`scene.pose: touch`: the robot's lowest collider is on the ground, by closed forms and by MuJoCo."""

import math
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.export.ground.standing import stand
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Keyframe, Limits, Primitive, frozen
from tests.support.building import NO_MESHES, plan_of, write
from tests.support.exports import exported
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


@settings(max_examples=60)
@given(kind=st.sampled_from(["box", "sphere", "cylinder", "capsule"]), rpy=st.tuples(TURN, TURN, TURN))
def test_primitive_in_any_pose_touches_the_ground(kind, rpy):
    sizes = {"box": (0.1, 0.2, 0.3), "sphere": (0.1,), "cylinder": (0.1, 0.3), "capsule": (0.1, 0.3)}
    pose = frozen(from_parts(rotation_from_rpy(rpy), np.array([0.1, -0.2, 0.3])))
    robot = robot_with(shapes={"base": (Primitive(kind, sizes[kind], pose),)}, fixed=False)
    with TemporaryDirectory() as folder:
        model = scene_of(robot, Path(folder), export={"mjcf": {}})
    floor = model.geom("floor").id
    (collider,) = [geom for geom in range(model.ngeom) if model.geom_contype[geom] and geom != floor]
    apart = mujoco.mj_geomDistance(model, state(model), collider, floor, 1.0, np.zeros(6))
    assert abs(apart) < 1e-6
    assert standing(robot).low[2] == pytest.approx(0.0, abs=1e-8)


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
