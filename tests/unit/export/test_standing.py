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

from linkwright.stages.export import export
from linkwright.stages.export.ground.standing import stand
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Base, Keyframe, Limits, Primitive, frozen
from tests.support.building import NO_MESHES, plan_of, write
from tests.support.robots import at, joint, robot_with
from tests.support.touching import NO_FILES, no_memo

TURN = st.floats(-3.0, 3.0)


def shaped(robot, **shapes):
    """The robot with primitives as the shapes of its links, both to see and to touch."""
    links = tuple(replace(link, shapes=tuple(shapes.get(link.name, ()))) for link in robot.links)
    return replace(robot, links=links)


def geometry_of(robot, **mesh):
    return make_geometry(robot, NO_FILES, plan_of(mesh=mesh), no_memo)


def free(robot):
    return replace(robot, base=Base(False, "it floats"))


def legged():
    """A box on one leg that points down and to the side, with a ball of a foot; saved and limited so that at
    home the hip is at 0.5 rad."""
    joints = [joint("revolute", "base", "leg", name="hip", saved=[0.2], limits={"hip": Limits(0.5, 1.0)})]
    robot = robot_with(joints)
    body = Primitive("box", (0.2, 0.1, 0.06), frozen(np.eye(4)))
    foot = Primitive("sphere", (0.02,), frozen(at(0.3, 0.0, -0.25)))
    return shaped(robot, base=[body], leg=[foot])


@settings(max_examples=60)
@given(kind=st.sampled_from(["box", "sphere", "cylinder", "capsule"]), rpy=st.tuples(TURN, TURN, TURN))
def test_primitive_in_any_pose_touches_the_ground(kind, rpy):
    sizes = {"box": (0.1, 0.2, 0.3), "sphere": (0.1,), "cylinder": (0.1, 0.3), "capsule": (0.1, 0.3)}
    pose = frozen(from_parts(rotation_from_rpy(rpy), np.array([0.1, -0.2, 0.3])))
    robot = shaped(free(robot_with([])), base=[Primitive(kind, sizes[kind], pose)])
    geometry = geometry_of(robot)
    with TemporaryDirectory() as folder:
        write(robot, Path(folder), plan_of(export={"mjcf": {}}), geometry)
        model = mujoco.MjModel.from_xml_path(str(Path(folder) / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    fromto = np.zeros(6)
    (collider,) = [
        geom for geom in range(model.ngeom) if model.geom_contype[geom] and geom != model.geom("floor").id
    ]
    apart = mujoco.mj_geomDistance(model, data, collider, model.geom("floor").id, 1.0, fromto)
    assert abs(apart) < 1e-6
    low = stand(robot, geometry, plan_of()).low
    assert low[2] == pytest.approx(0.0, abs=1e-8)


def test_a_free_robot_stands_on_its_lowest_collider_at_home(tmp_path):
    robot = free(legged())
    write(robot, tmp_path, plan_of(), geometry_of(robot))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    # The foot turns about z with the hip, so its height is that in the leg's frame.
    assert data.qpos[2] == pytest.approx(0.27, abs=1e-9)
    foot = next(g for g in range(model.ngeom) if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_SPHERE)
    assert data.geom_xpos[foot][2] - 0.02 == pytest.approx(0.0, abs=1e-9)
    assert data.geom_xpos[foot][0] == pytest.approx(0.3 * math.cos(0.5), abs=1e-9)


def bending():
    """The robot whose hip swings its leg up, saved with a straight leg, at home and in a pose of its own with
    a bent one."""
    upright = from_parts(rotation_from_rpy((math.pi / 2, 0.0, 0.0)), np.zeros(3))
    robot = robot_with([joint("revolute", "base", "leg", name="hip", place=upright)])
    foot = Primitive("sphere", (0.02,), frozen(at(0.0, -0.25, 0.0)))
    named = tuple(Keyframe(name, (("hip", value),)) for name, value in (("home", 0.4), ("tuck", 1.2)))
    return replace(shaped(free(robot), leg=[foot]), keyframes=named)


def test_free_robot_touches_the_ground_in_all_keyframes(tmp_path):
    robot = bending()
    write(robot, tmp_path, plan_of(), geometry_of(robot))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    heights = {model.key(index).name: float(model.key_qpos[index][2]) for index in range(model.nkey)}
    bent = {"home": 0.4, "tuck": 1.2, "cad": 0.0}
    expected = {name: pytest.approx(0.25 * math.cos(hip) + 0.02, abs=1e-8) for name, hip in bent.items()}
    assert (heights, float(model.qpos0[2])) == (expected, expected["cad"])


def test_sdf_at_zero_touches_the_ground():
    robot = bending()
    plan = plan_of(export={"sdf": {}})
    text = export(robot, geometry_of(robot), plan).files[f"{robot.name}.sdf"].decode()
    height = float(text.partition("<pose>")[2].split()[2])
    assert height == pytest.approx(0.27, abs=1e-8)


def test_fixed_robot_stands_on_its_fixed_links():
    robot = legged()
    standing = stand(robot, geometry_of(robot), plan_of())
    assert standing.world_from_root[2, 3] == pytest.approx(0.03, abs=1e-9)
    (diagnostic,) = standing.diagnostics
    assert (diagnostic.code, diagnostic.where) == ("W-GROUND", "leg")
    assert "240 mm in the ground" in diagnostic.message


@pytest.mark.parametrize(
    ("off", "stays"), [(0.0019, True), (-0.0019, True), (0.0021, False), (-0.0021, False)]
)
def test_fixed_robot_stays_within_the_slack_of_a_collider(off, stays):
    box = Primitive("box", (0.2, 0.1, 0.06), frozen(at(0.0, 0.0, 0.03 - off)))
    robot = shaped(robot_with([]), base=[box])
    for base, moved in ((robot, not stays), (free(robot), True)):
        standing = stand(base, geometry_of(base), plan_of())
        assert standing.world_from_root[2, 3] == pytest.approx(off if moved else 0.0, abs=1e-9)


def test_without_colliders_the_visuals_of_the_base_stand():
    robot = legged()
    standing = stand(robot, geometry_of(robot, collider="visual"), plan_of(mesh={"collider": "visual"}))
    assert standing.world_from_root[2, 3] == pytest.approx(0.03, abs=1e-9)


@pytest.mark.parametrize("tilt", [0.3, -0.8])
def test_on_a_slope_it_moves_along_the_vertical(tilt):
    robot = shaped(free(robot_with([])), base=[Primitive("sphere", (0.1,), frozen(at(0.4, 0.0, 0.0)))])
    ground = {"xyz": [0, 0, -0.2], "rpy": [0, tilt, 0]}
    standing = stand(robot, geometry_of(robot), plan_of(ground=ground))
    height = -0.2 - 0.4 * math.tan(tilt) + 0.1 / math.cos(tilt)
    assert standing.world_from_root[2, 3] == pytest.approx(height, abs=1e-8)
    assert standing.world_from_root[:2, 3].tolist() == [0.0, 0.0]


def test_a_wall_is_no_ground():
    robot = free(legged())
    with pytest.raises(ExportError) as caught:
        stand(robot, geometry_of(robot), plan_of(ground={"rpy": [0, 1.55, 0]}))
    assert "too steep" in str(caught.value)
    assert caught.value.where == "scene.pose"


@pytest.mark.parametrize("keys", [{"ground": {"kind": "none"}}, {"scene": {"pose": {"xyz": [0, 0, 0]}}}])
def test_without_a_ground_or_with_a_pose_it_stays(keys):
    robot = free(legged())
    standing = stand(robot, geometry_of(robot), plan_of(**keys))
    np.testing.assert_array_equal(standing.world_from_root, np.eye(4))
    np.testing.assert_array_equal(standing.placed({"hip": 1.0}), np.eye(4))
    diagnostics = [diagnostic.where for diagnostic in standing.diagnostics]
    assert diagnostics == ([] if "ground" in keys else ["base", "leg"])


def test_a_robot_without_shapes_stays():
    standing = stand(free(legged()), NO_MESHES, plan_of())
    np.testing.assert_array_equal(standing.world_from_root, np.eye(4))
    assert not np.isfinite(standing.low).any()
