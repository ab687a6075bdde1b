"""The world around the robot: every key of `ground` and `scene` shows in the compiled model."""

import itertools
import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.stages.export.configuration.mujoco_section import (
    RESERVED_ATTRIBUTES,
    ROBOT_FILE_OPTIONS,
    CompilerSection,
    FlagsSection,
    LengthRangeSection,
    OptionSection,
)
from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.geom_form import GeomForm
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Frame, frozen
from tests.support.mjcfs import body, built, rebuilt, written
from tests.support.mjcfs import model as mjcf
from tests.support.mujoco_schema import schema
from tests.support.robots import at, joint, robot_with
from tests.support.states import pose_of, state
from tests.support.touching import ball, box
from tests.unit.export.test_standing import scene_of


def arm(**more):
    hinge = joint("revolute", "base", "arm", name="elbow", saved=[0.4])
    shapes = {"base": (box(0.2, 0.1, 0.3),), "arm": (ball(0.05, at(0.3, 0, 0)),)}
    eye = Frame("eye", "arm", frozen(at(0.1, 0.0, 0.05)), "eye")
    return robot_with([hinge], frames=[eye], shapes=shapes, **more)


def scene(folder, **keys):
    """The compiled scene, its text, and that of the robot alone."""
    model = scene_of(arm(), folder, **keys)
    return model, (folder / "scene.xml").read_text(), (folder / "robot.xml").read_text()


def attributes(element):
    """The attributes of an element in the schema of the MuJoCo that is installed."""
    (names_of_element,) = [names for where, names in schema() if where[-1:] == (element,)]
    return set(names_of_element)


@pytest.mark.parametrize(("element", "section", "without"), [
    ("option", OptionSection, ()),
    ("flag", FlagsSection, ()),
    ("compiler", CompilerSection, RESERVED_ATTRIBUTES),
    ("lengthrange", LengthRangeSection, ()),
])  # fmt: skip
def test_every_attribute_of_mujoco_is_a_key(element, section, without):
    assert "timestep" in attributes("option")
    assert attributes(element) - set(without) <= set(section.model_fields)


VALUES = {
    "gravity": [0, 0, -1.62], "wind": [1, 0, 0], "magnetic": [0, 0.1, 0], "density": 1.2, "viscosity": 2e-5,
    "tolerance": 1e-9, "ls_tolerance": 0.02, "noslip_tolerance": 1e-5, "ccd_tolerance": 1e-7,
    "iterations": 50, "ls_iterations": 20, "noslip_iterations": 3, "ccd_iterations": 40, "sdf_iterations": 7,
    "sdf_initpoints": 30, "impratio": 10, "timestep": 0.001, "o_margin": 0.01,
}  # fmt: skip


@pytest.mark.parametrize("name", VALUES)
def test_option_is_that_of_the_model(tmp_path, name):
    model, world, robot = scene(tmp_path, scene={"option": {name: VALUES[name]}})
    np.testing.assert_allclose(getattr(model.opt, name), VALUES[name])
    assert (f' {name}="' in "".join(re.findall("<option.*", robot))) == (name in ROBOT_FILE_OPTIONS)
    assert (f' {name}="' in "".join(re.findall("<option.*", world))) == (name not in ROBOT_FILE_OPTIONS)


def test_words_and_flags_of_the_options_are_in_the_model(tmp_path):
    option = {"cone": "elliptic", "solver": "CG", "jacobian": "dense", "integrator": "RK4"}
    flag = {"gravity": "disable", "energy": "enable"}
    model, world, robot = scene(tmp_path, scene={"option": {**option, "flag": flag}})
    own = model.opt
    assert (own.cone, own.solver) == (mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtSolver.mjSOL_CG)
    assert own.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
    assert own.integrator == mujoco.mjtIntegrator.mjINT_RK4
    assert own.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    assert own.enableflags & mujoco.mjtEnableBit.mjENBL_ENERGY
    assert "cone" in robot
    assert ("<flag" in world, "<flag" in robot) == (True, False)


def test_options_that_are_not_given_are_not_written(tmp_path):
    model, world, robot = scene(tmp_path)
    assert not re.findall("<option|<compiler", world)
    assert re.findall("<option [^>]*>", robot) == ['<option timestep="0.002" integrator="implicitfast"/>']
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST


def test_settings_of_the_compiler_are_in_the_model(tmp_path):
    model, world, _ = scene(tmp_path, scene={"compiler": {"boundmass": 3.5, "lengthrange": {"mode": "none"}}})
    assert model.body_mass[1:].min() == 3.5
    assert '<lengthrange mode="none"/>' in world


def test_ground_has_its_size_place_and_material(tmp_path):
    assert scene(tmp_path)[0].geom("floor").matid >= 0
    model, text, _ = scene(tmp_path, ground={"size": None, "material": "plain"})
    floor = model.geom("floor")
    assert (floor.size[:2].tolist(), floor.matid, "checker" in text) == ([0, 0], -1, False)
    keys = {"size": [2, 3], "xyz": [0, 0, -0.5], "friction": [0.7, 0.01, 0.001]}
    floor = scene(tmp_path, ground=keys)[0].geom("floor")
    assert (floor.size[:2].tolist(), floor.pos.tolist()) == ([1, 1.5], [0, 0, -0.5])
    assert floor.friction.tolist() == [0.7, 0.01, 0.001]
    model, text, _ = scene(tmp_path, ground={"kind": "none"})
    assert "floor" not in text
    assert not any(model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE)


def test_lights_and_the_sky_are_in_the_scene(tmp_path):
    model, _, _ = scene(tmp_path)
    assert [model.light(index).name for index in range(model.nlight)] == ["sun"]
    lamp = {"kind": "spot", "xyz": [1, 2, 3], "direction": [0, 1, -1], "diffuse": [1, 0.5, 0], "cutoff": 30}
    lights = {"sun": "none", "lamp": {**lamp, "shadow": False}}
    model, text, _ = scene(tmp_path, scene={"lights": lights, "skybox": "none"})
    light = model.light("lamp")
    assert (model.nlight, light.pos.tolist()) == (1, [1, 2, 3])
    np.testing.assert_allclose(light.dir, np.array([0, 1, -1]) / np.sqrt(2))
    np.testing.assert_allclose(light.diffuse, [1, 0.5, 0])
    assert (light.cutoff, light.castshadow) == (30, False)
    assert "skybox" not in text
    _, text, _ = scene(tmp_path, scene={"skybox": {"top": [0.1, 0.2, 0.3]}})
    assert 'rgb1="0.1 0.2 0.3"' in text


def looks(model, name):
    """Where a camera is at home, and the directions of its view and of the image's right, in the world."""
    world_from_camera = pose_of(state(model, "home").cam(name))
    return world_from_camera[:3, 3], -world_from_camera[:3, 2], world_from_camera[:3, 0]


def test_camera_in_the_world_looks_at_its_point(tmp_path):
    camera = {"xyz": [1, 0, 0.5], "look_at": [0, 0, 0.5], "fovy": 60, "resolution": [320, 200]}
    model, world, robot = scene(tmp_path, scene={"cameras": {"side": camera}})
    place, view, right = looks(model, "side")
    np.testing.assert_allclose(place, [1, 0, 0.5])
    np.testing.assert_allclose(view, [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(right, [0, 1, 0], atol=1e-12)
    assert model.cam("side").fovy == 60
    assert model.cam_resolution[model.cam("side").id].tolist() == [320, 200]
    assert 'name="side"' in world
    assert "camera" not in robot


def test_camera_on_a_frame_moves_with_it_and_is_the_robots(tmp_path):
    camera = {"frame": "eye", "xyz": [0, 0, 0.01], "rpy": [0.1, 0.2, 0.3]}
    model, world, robot = scene(tmp_path, scene={"cameras": {"wrist": camera}})
    assert 'camera name="wrist"' in robot
    assert "wrist" not in world
    place, view, right = looks(model, "wrist")
    world_from_eye = pose_of(state(model, "home").site("eye"))
    expected = world_from_eye @ from_parts(rotation_from_rpy((0.1, 0.2, 0.3)), np.array([0, 0, 0.01]))
    np.testing.assert_allclose(place, expected[:3, 3], atol=1e-10)
    np.testing.assert_allclose(view, expected[:3, 2], atol=1e-10)
    np.testing.assert_allclose(right, expected[:3, 0], atol=1e-10)


def test_camera_on_no_frame_is_refused(tmp_path):
    with pytest.raises(ExportError) as caught:
        scene(tmp_path, scene={"cameras": {"wrist": {"frame": "eyes"}}})
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("E-FRAME", "scene.cameras.wrist.frame")
    assert "eye" in problem.hint


def test_overview_sees_every_corner_of_the_robot(tmp_path):
    model, _, _ = scene(tmp_path)
    place, view, right = looks(model, "overview")
    data = state(model, "home")
    for geom in {*range(model.ngeom)} - {model.geom("floor").id}:
        for sign, axis in itertools.product((-1, 1), range(3)):
            reach = sign * model.geom_size[geom][axis] * data.geom_xmat[geom][axis::3]
            away = data.geom_xpos[geom] + reach - place
            x, y, z = away @ np.column_stack([right, np.cross(view, right), view])
            assert max(abs(x), abs(y)) < z * np.tan(np.radians(22.5))
    assert (model.stat.center > [-0.1, -0.05, 0.0]).all()
    assert (model.stat.center < [0.35, 0.15, 0.3]).all()
    assert 0.25 < model.stat.extent < 0.6


def scene_of_source(folder, inside="", more="", **keys):
    """The compiled scene of an MJCF source with an arm that carries `inside`."""
    arm = body("arm", f'<joint axis="0 1 0"/>{inside}', pos="0 0 1")
    files = rebuilt(written(folder, mjcf(arm, more)), **keys).files
    return mujoco.MjModel.from_xml_string(files["scene.xml"].decode(), files)


MOON = [0, 0, -1.62]
NO_GRAVITY = int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)


def test_gravity_of_the_user_holds_if_the_source_sets_the_flag(tmp_path):
    more, option = '<option><flag gravity="disable"/></option>', {"gravity": MOON}
    options = scene_of_source(tmp_path, more=more, scene={"option": option}).opt
    assert (options.gravity.tolist(), options.disableflags & NO_GRAVITY) == (MOON, NO_GRAVITY)


def test_flag_of_the_user_holds_if_the_source_sets_gravity(tmp_path):
    more, option = '<option gravity="0 0 -1.62"/>', {"flag": {"gravity": "disable"}}
    options = scene_of_source(tmp_path, more=more, scene={"option": option}).opt
    assert (options.gravity.tolist(), options.disableflags & NO_GRAVITY) == (MOON, NO_GRAVITY)


def test_sun_has_another_name_if_the_robot_carries_one(tmp_path):
    model = scene_of_source(tmp_path, '<light name="sun"/>')
    assert [model.light(index).name for index in range(model.nlight)] == ["sun_2", "sun"]


def test_overview_is_the_camera_of_the_robot_if_it_has_one(tmp_path):
    model = scene_of_source(tmp_path, '<camera name="overview" fovy="33"/>')
    assert (model.ncam, model.camera("overview").fovy[0]) == (1, 33)


def test_floor_has_another_name_if_a_collider_has_its_name(tmp_path):
    foot = replace(ball(0.1), form=GeomForm("floor"))
    robot = robot_with([joint("revolute", "base", "arm")], shapes={"arm": (foot,)})
    model = scene_of(robot, tmp_path)
    assert model.geom("floor_2").type[0] == mujoco.mjtGeom.mjGEOM_PLANE


def test_collider_has_another_name_than_a_geom_of_the_scene(tmp_path):
    cup = body("cup", '<freejoint/><geom name="arm_collision" size="0.1"/>', pos="1 0 1")
    arm = body("arm", '<joint axis="0 1 0"/><geom size="0.1"/>', pos="0 0 1")
    _, failed = built(written(tmp_path, mjcf(cup + arm)), tmp_path / "out")
    assert not failed
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out/scene.xml"))
    assert model.geom("arm_collision_2").bodyid == model.body("arm").id
