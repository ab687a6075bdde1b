"""The example of the original Robot class as one YAML file: its MJCF has all that was set by hand there."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.build import build_files
from linkwright.stages.formats.xml import parse
from tests.support.users import write

TEXT = Path(__file__).with_name("original_example.yaml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = write(tmp_path_factory.mktemp("example"), example=TEXT)
    plan = compose_plan(["robot=example", f"cache.dir={folder}/cache"], (), folder).plan
    return build_files(plan, in_memory=True)


@pytest.fixture(scope="module")
def model(built):
    files = {Path(path).name: data for path, data in built.files.items()}
    return mujoco.MjModel.from_xml_string(files["scene.xml"].decode(), files)


def rest(model):
    """At home, without controls."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    data.ctrl[:] = 0
    mujoco.mj_forward(model, data)
    return data


def test_every_check_passes(built):
    assert [check for check in built.report.checks if check.fails] == []
    assert built.report.status == "built"


def test_the_robot_floats_at_its_position(model):
    assert model.joint(0).type[0] == mujoco.mjtJoint.mjJNT_FREE
    assert rest(model).qpos[:3].tolist() == [0, 0, 0.35]


def test_options_and_compiler(model, built):
    assert (model.opt.timestep, model.opt.iterations) == (0.001, 50)
    assert model.opt.gravity.tolist() == [0, 0, -9.81]
    assert parse(built.files["scene.xml"]).find("compiler").get("balanceinertia") == "true"


def test_lights_and_a_camera(model):
    assert {model.light(number).name for number in range(model.nlight)} == {"sun", "light_1", "light_2"}
    assert model.light("light_1").diffuse.tolist() == [1, 1, 1]
    assert not model.light("light_1").castshadow
    data = rest(model)
    view = -data.cam("track").xmat.reshape(3, 3)[:, 2]
    towards = np.array([0, 0, 0.3]) - data.cam("track").xpos
    np.testing.assert_allclose(view, towards / np.linalg.norm(towards), atol=1e-6)


def test_motors_with_encoder_and_force_sensor(model):
    names = ("shoulder_yaw", "shoulder", "wrist_pitch")
    assert [model.actuator(number).name for number in range(model.nu)] == list(names)
    assert model.actuator("shoulder").ctrlrange.tolist() == [-20, 20]
    data = rest(model)
    data.joint("wrist_pitch").qvel[0] = 0.3
    data.actuator("wrist_pitch").ctrl[0] = 1.5
    mujoco.mj_forward(model, data)
    for name in names:
        gear, joint = model.actuator(name).gear[0], data.joint(name)
        assert data.sensor(f"{name}_pos").data[0] == pytest.approx(gear * joint.qpos[0], abs=1e-12)
        assert data.sensor(f"{name}_vel").data[0] == pytest.approx(gear * joint.qvel[0], abs=1e-12)
        assert data.sensor(f"{name}_force").data[0] == pytest.approx(data.actuator(name).force[0], abs=1e-12)
    assert data.sensor("wrist_pitch_vel").data[0] == pytest.approx(5 * 0.3)
    assert data.sensor("wrist_pitch_force").data[0] == pytest.approx(1.5)


def test_an_imu(model):
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    turned = data.site("imu").xmat.reshape(3, 3)
    # What falls freely feels nothing, what is held feels all of gravity.
    np.testing.assert_allclose(data.sensor("imu_accelerometer").data, 0, atol=1e-9)
    data.qacc[:] = 0
    mujoco.mj_rnePostConstraint(model, data)
    mujoco.mj_sensorAcc(model, data)
    np.testing.assert_allclose(turned @ data.sensor("imu_accelerometer").data, [0, 0, 9.81], atol=1e-9)
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, turned.ravel())
    assert abs(quat @ data.sensor("imu_quat").data) == pytest.approx(1)
    assert model.sensor("imu_gyro").noise[0] == 0.01


def test_elements_and_attributes_of_ones_own(model, built):
    case = model.geom("imu_case")
    assert model.body(int(case.bodyid[0])).name == "wrist"
    assert case.rgba.tolist() == [1, 0, 0, 1]
    assert model.geom("wall").friction.tolist() == [0.1, 0.005, 0.0001]
    assert model.geom("floor").friction.tolist() == [1, 0.5, 0.5]
    gazebo = parse(built.files["example.urdf"]).find("gazebo")
    assert gazebo.get("reference") == "wrist"
    assert gazebo.findtext("mu1") == "0.5"
