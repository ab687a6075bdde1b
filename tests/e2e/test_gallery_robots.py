"""The delta, the rover and the hand of the gallery do what they are for."""

import mujoco
import numpy as np
import pytest

from tests.fake_onshape import hand, rover
from tests.fake_onshape.delta import AXES, arm_angles, depth
from tests.fake_onshape.delta_parts import TOOL
from tests.fake_onshape.hand_parts import FINGERS
from tests.fake_onshape.rover_parts import AXLE, WHEEL
from tests.support.command import called, environment

ROBOTS = ("delta", "rover", "hand")


@pytest.fixture(scope="module")
def models(tmp_path_factory, shared_cache):
    """Robot → its scene, without the colliders that take long to make."""
    here, built = tmp_path_factory.mktemp("gallery"), {}
    environ = environment(here, seeded=False, LINKWRIGHT_CACHE=str(shared_cache))

    def model(name):
        if name not in built:
            called(here, f"robot={name}", "mesh=visual", "validate=quick", environ=environ, status=0)
            built[name] = mujoco.MjModel.from_xml_path(str(here / "outputs" / name / "scene.xml"))
        return built[name]

    return model


def at_home(model):
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    return data


def run(model, data, seconds, **controls):
    """Simulates with these controls; yields after each step."""
    for name, value in controls.items():
        data.ctrl[model.actuator(name).id] = value
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        yield


def wait(*arguments, **controls):
    for _ in run(*arguments, **controls):
        pass


def value(data, joint):
    return float(data.joint(joint).qpos[0])


def gap(model, data):
    """The largest distance [m] between the two sites of a loop."""
    pairs = zip(model.eq_obj1id, model.eq_obj2id, strict=True)
    return max(np.linalg.norm(data.site_xpos[first] - data.site_xpos[second]) for first, second in pairs)


@pytest.mark.parametrize("name", ROBOTS)
def test_robot_stays_where_it_is_at_home(name, models):
    model = models(name)
    data = at_home(model)
    before = data.qpos.copy()
    wait(model, data, 5.0)
    assert np.abs(data.qpos - before).max() < 2e-3
    assert np.abs(data.qvel).max() < 1e-4
    assert not any(warning.number for warning in data.warning)


PLACES = [(0.0, 0.0, 0.21), (0.08, 0.0, 0.20), (-0.05, 0.07, 0.16), (0.0, -0.09, 0.15)]


def test_delta_goes_to_places_with_its_loops_closed(models):
    """The angles are of the textbook's inverse kinematics; motors of the library sag by some 20 mrad."""
    model = models("delta")
    data = at_home(model)
    names = [f"shoulder_{number}" for number in (1, 2, 3)]
    assert [model.actuator(number).name for number in range(model.nu)] == names
    assert int(np.sum(model.eq_type == mujoco.mjtEq.mjEQ_CONNECT)) == model.neq == 5
    np.testing.assert_allclose(data.site("tool").xpos, [0, 0, AXES - depth() - TOOL], atol=1e-9)
    assert gap(model, data) < 1e-9
    for place in PLACES:
        for _ in run(model, data, 2.0, **dict(zip(names, arm_angles(place), strict=True))):
            assert gap(model, data) < 2e-4
        assert gap(model, data) < 1e-6
        np.testing.assert_allclose(data.site("tool").xpos, np.subtract(place, (0, 0, TOOL)), atol=2.5e-3)
        reached = arm_angles(np.add(data.site("tool").xpos, (0, 0, TOOL)))
        np.testing.assert_allclose(reached, [value(data, name) for name in names], atol=1e-5)
        np.testing.assert_allclose(data.site("tool").xmat.reshape(3, 3), np.diag([1, -1, -1]), atol=1e-4)


def test_rover_drives_a_metre_ahead_and_turns_on_the_spot(models):
    model = models("rover")
    data = at_home(model)
    speed = 5.0
    wait(model, data, 1.0, left_drive=speed, right_drive=speed)
    start, turned = data.qpos[:3].copy(), value(data, "left_drive")
    while value(data, "left_drive") - turned < 1.0 / WHEEL:
        wait(model, data, model.opt.timestep)
    np.testing.assert_allclose(data.qpos[:3] - start, [1.0, 0.0, 0.0], atol=0.01)
    wait(model, data, 0.5, left_drive=0.0, right_drive=0.0)
    stop, wheels = data.qpos[:2].copy(), turned_apart(data)
    wait(model, data, 1.5, left_drive=-speed / 2, right_drive=speed / 2)
    matrix = data.body("chassis").xmat.reshape(3, 3)
    yaw = np.arctan2(matrix[1, 0], matrix[0, 0])
    assert yaw == pytest.approx((turned_apart(data) - wheels) * WHEEL / (2 * AXLE[1]), rel=0.06)
    assert 1.2 < yaw < 1.8
    assert np.linalg.norm(data.qpos[:2] - stop) < 0.12  # it turns about its axle
    assert abs(np.linalg.norm(data.joint("caster").qpos) - 1) < 1e-9


def turned_apart(data):
    """How far [rad] the right wheel has turned more than the left one."""
    return value(data, "right_drive") - value(data, "left_drive")


def test_rover_grips_with_fingers_that_mirror_each_other(models):
    model = models("rover")
    data = at_home(model)
    assert "right_finger" not in [model.actuator(number).name for number in range(model.nu)]
    for target in (0.005, 0.040):
        for _ in run(model, data, 1.5, left_finger=target, lift=0.14):
            assert value(data, "right_finger") == pytest.approx(value(data, "left_finger"), abs=2e-4)
        assert value(data, "left_finger") == pytest.approx(target, abs=1e-3)
        tool = frame_of(data.site("tool"))
        left, right = (tool @ [*data.body(f"{side}_jaw").xpos, 1] for side in ("left", "right"))
        np.testing.assert_allclose(left, right * [-1, 1, 1, 1], atol=2e-4)
        assert 2 * target < abs(left[0] - right[0]) + 1e-3
    assert value(data, "lift") == pytest.approx(0.14, abs=2e-3)


def frame_of(site):
    """(4, 4) from the world to a site."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = site.xmat.reshape(3, 3), site.xpos
    return np.linalg.inv(matrix)


def test_rover_sees_its_tool_and_turns_its_camera(models):
    """MuJoCo's cameras look along −z, with y up."""
    model = models("rover")
    data = at_home(model)
    eye = model.camera("eye")
    assert model.cam_resolution[eye.id].tolist() == [320, 240]

    def seen():
        """(x, y) of the tool in the image: −1 to 1 between its edges."""
        rows = data.camera("eye").xmat.reshape(3, 3)
        x, y, z = rows.T @ (data.site("tool").xpos - data.camera("eye").xpos)
        assert z < 0
        half = np.tan(np.radians(eye.fovy[0]) / 2) * -z
        return x / half / (320 / 240), y / half

    x, y = seen()
    look = -data.camera("eye").xmat.reshape(3, 3)[:, 2]
    np.testing.assert_allclose(look, [np.cos(rover.LOOK), 0, -np.sin(rover.LOOK)], atol=1e-3)
    wait(model, data, 1.0, camera_tilt=0.9)
    lower_x, lower_y = seen()
    assert y < -0.5 < lower_y < 1
    assert max(abs(x), abs(lower_x)) < 0.3


@pytest.mark.parametrize("pose", ["fist", "point", "home"])
def test_hand_closes_with_its_joints_coupled(pose, models):
    model = models("hand")
    data = at_home(model)
    key = model.key(pose)
    assert model.nu == len(FINGERS) + 2
    data.ctrl[:] = key.ctrl
    for _ in run(model, data, 2.0):
        assert uncoupled(data) < 2e-3
    assert uncoupled(data) < 1e-5
    np.testing.assert_allclose(data.qpos, key.qpos, atol=0.02)


def uncoupled(data):
    """How far [rad] any joint is from what its relation says."""
    errors = [value(data, "thumb_tip") - hand.THUMB_TIP * value(data, "thumb_bend")]
    for finger in map(str.lower, FINGERS):
        bend = value(data, f"{finger}_bend")
        errors.append(bend - hand.CURL * value(data, f"{finger}_knuckle"))
        errors.append(value(data, f"{finger}_tip") - hand.TIP * bend)
    return max(map(abs, errors))
