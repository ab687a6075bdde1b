"""The key `sensors`: what measures the robot, and what the compiled model measures."""

import json
import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.export.configuration.sensor_section import MEASURES, SensorSection
from linkwright.stages.formats.xml import parse
from linkwright.stages.mesh.collide.primitives import shapes as primitive_shapes
from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.poses import from_parts, turn
from linkwright.stages.robot.model.robot import Frame, Limits, Primitive, Sensor, frozen
from linkwright.stages.validate import validate
from tests.support.building import NO_MESHES, plan_of, write
from tests.support.exports import compiled, exported
from tests.support.robots import at, joint, loop, pose, robot_with

GRAVITY = 9.81
FILE = Path(__file__).parent / "golden" / "sensors.yaml"
GOLDEN = yaml.safe_load(FILE.read_text(encoding="utf-8"))
"""Title → keys of the configuration, and the elements that they come to."""

TILT = pose(np.random.default_rng(1))
PLACE = pose(np.random.default_rng(2))


def arm(**more):
    """base – turn with limits – arm – fixed – hand, with the frame `mount` – ball – eye."""
    joints = [
        joint("revolute", "base", "arm", place=PLACE, limits={"arm_joint": Limits(-1.0, 1.0)}),
        joint("fixed", "arm", "hand", place=TILT),
        joint("ball", "hand", "eye", place=at(0, 0.1, 0)),
    ]
    frames = (Frame("mount", "hand", frozen(PLACE @ TILT), "Mount"),)
    box = {"hand": (Primitive("box", (0.1, 0.2, 0.3), frozen(at(0.01, 0.02, 0.03))),)}
    return robot_with(joints, frames=frames, shapes=box, **more)


def solid(robot):
    return Geometry(tuple(shape for link in robot.links for shape in primitive_shapes(link)), {})


def measured(robot, **keys):
    """The export of a robot with its colliders."""
    return exported(robot, solid(robot), **keys)


def forward(model, **speeds):
    """The state at the keyframe `home` with these speeds of joints."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    for name, speed in speeds.items():
        data.joint(name).qvel[0] = speed
    mujoco.mj_forward(model, data)
    return data


def read(data, name):
    return np.array(data.sensor(name).data)


def site(data, name):
    """world_from_site (4, 4)."""
    named = data.site(name)
    return from_parts(named.xmat.reshape(3, 3), named.xpos)


def problem(robot, sensors, **keys):
    with pytest.raises(ExportError) as error:
        measured(robot, sensors=sensors, **keys)
    (only,) = error.value.problems
    return only.code, only.where, only.message, only.hint


def elements(outcome):
    """The sites, cameras and sensors of a model that the bare robot does not have, as text."""
    root = parse(outcome.files["robot.xml"])
    sensors = [node for section in root.iterchildren("sensor") for node in section]
    nodes = [*(node for node in root.iter("site", "camera") if node.get("name") not in ("mount", "hand"))]
    return [
        f"{node.tag} {' '.join(f'{key}={value}' for key, value in node.attrib.items())}"
        for node in (*nodes, *sensors)
    ]


def of_golden(keys):
    return measured(arm(), **({"actuators": {"arm_joint": {"type": "motor"}}} | keys))


@pytest.mark.parametrize("title", GOLDEN)
def test_each_option_comes_to_its_golden_and_compiles(title):
    keys, expected = GOLDEN[title]["keys"], GOLDEN[title]["elements"]
    outcome = of_golden(keys)
    assert elements(outcome) == expected, "if this is meant: python -m tests.unit.export.test_sensors"
    model = compiled(outcome)
    assert [model.sensor(index).name for index in range(model.nsensor)] == [
        text.split("name=")[1].split()[0] for text in expected if not text.startswith(("site ", "camera "))
    ]
    assert outcome.files["robot.urdf"] == of_golden({}).files["robot.urdf"]


def test_types_measurements_and_options_have_goldens():
    entries = [
        (entry, GOLDEN[title]["elements"])
        for title in GOLDEN
        for entry in GOLDEN[title]["keys"].get("sensors", {}).values()
    ]
    for kind, measures in MEASURES.items():
        tags = {text.split()[0] for entry, texts in entries if entry["type"] == kind for text in texts}
        assert set(measures.values()) <= tags, kind
    keys = {key for entry, _ in entries for key in entry}
    assert keys == set(SensorSection.model_fields)


def test_accelerometer_at_rest_reads_gravity_upwards():
    model = compiled(
        measured(
            arm(), sensors={"imu": {"type": "imu", "frame": "mount", "xyz": [0.1, 0, 0], "rpy": [1, 2, 3]}}
        )
    )
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EQUALITY
    model.dof_damping[:] = 1e9  # holds it still
    model.dof_armature[:] = 1e9
    data = forward(model)
    world_from_imu = site(data, "imu")
    upwards = world_from_imu[:3, :3].T @ [0, 0, GRAVITY]
    np.testing.assert_allclose(read(data, "imu_accelerometer"), upwards, atol=1e-6)
    offset = np.linalg.inv(site(data, "mount")) @ world_from_imu
    np.testing.assert_allclose(offset[:3, 3], [0.1, 0, 0], atol=1e-12)
    w, x, y, z = read(data, "imu_quat")
    rotated = np.zeros(9)
    mujoco.mju_quat2Mat(rotated, [w, x, y, z])
    np.testing.assert_allclose(rotated.reshape(3, 3), world_from_imu[:3, :3], atol=1e-12)


def test_gyro_and_velocimeter_read_the_motion_of_a_joint():
    measure = ["gyro", "velocimeter", "magnetometer"]
    model = compiled(measured(arm(), sensors={"mount": {"type": "imu", "measure": measure}}))
    data = forward(model, arm_joint=0.7)
    axis, anchor = data.joint("arm_joint").xaxis, data.joint("arm_joint").xanchor
    world_from_mount = site(data, "mount")
    turned, away = world_from_mount[:3, :3], world_from_mount[:3, 3] - anchor
    np.testing.assert_allclose(read(data, "mount_gyro"), turned.T @ axis * 0.7, atol=1e-12)
    np.testing.assert_allclose(
        read(data, "mount_velocimeter"), turned.T @ np.cross(axis * 0.7, away), atol=1e-12
    )
    np.testing.assert_allclose(read(data, "mount_magnetometer"), turned.T @ model.opt.magnetic, atol=1e-12)


def test_sensors_of_joints_read_their_values():
    quantities = ["pos", "vel", "actuator_force", "limit_pos", "limit_vel", "limit_force"]
    sensors = {
        "all": {"type": "joint", "measure": quantities},
        "one": {"type": "joint", "joints": "arm_joint"},
    }
    model = compiled(measured(arm(), sensors=sensors, actuators={"*": "motor"}))
    data = forward(model)
    data.joint("arm_joint").qpos[0], data.joint("arm_joint").qvel[0] = 1.1, 0.4
    data.ctrl[0] = 0.3
    mujoco.mj_forward(model, data)
    expected = {"pos": 1.1, "vel": 0.4, "actuator_force": 0.3, "limit_pos": -0.1, "limit_vel": -0.4}
    for name, value in expected.items():
        assert read(data, f"all_arm_joint_{name}") == pytest.approx(value), name
    assert read(data, "all_arm_joint_limit_force") > 0
    np.testing.assert_array_equal(read(data, "all_eye_joint_pos"), [1, 0, 0, 0])
    assert len(read(data, "all_eye_joint_vel")) == 3
    assert read(data, "one_pos") == read(data, "all_arm_joint_pos")
    assert read(data, "one_vel") == read(data, "all_arm_joint_vel")
    names = {model.sensor(index).name for index in range(model.nsensor)}
    assert "all_eye_joint_limit_pos" not in names


def test_an_encoder_and_a_force_sensor_of_an_actuator_by_glob():
    actuators = {"*": {"type": "position", "kp": 50, "kv": 3, "gear": 2, "encoder": True, "force": True}}
    model = compiled(measured(arm(), actuators=actuators))
    data = forward(model)
    data.joint("arm_joint").qpos[0], data.joint("arm_joint").qvel[0], data.ctrl[0] = 0.5, 0.2, 0.7
    mujoco.mj_forward(model, data)
    assert [model.sensor(index).name for index in range(3)] == [
        "arm_joint_pos", "arm_joint_vel", "arm_joint_force",
    ]  # fmt: skip
    assert read(data, "arm_joint_pos") == pytest.approx(2 * 0.5)
    assert read(data, "arm_joint_vel") == pytest.approx(2 * 0.2)
    assert read(data, "arm_joint_force") == pytest.approx(50 * (0.7 - 1.0) - 3 * 0.4)


def test_an_entry_that_only_measures_drives_nothing():
    written = measured(arm(), actuators={"*": {"encoder": True}}).written
    assert written.actuation == measured(arm()).written.actuation
    code, where, message, hint = problem(arm(), {}, actuators={"arm*": {"force": True}})
    assert (code, where) == ("E-SENSOR", "actuators.arm*")
    assert message == "nothing drives 'arm*', so there is nothing to measure"
    assert "type" in hint
    measured(arm(), actuators={"arm*": {"force": False}})


def test_later_entry_takes_an_encoder_away():
    actuators = {"*": {"type": "motor", "encoder": True}, "arm_joint": {"encoder": False, "force": True}}
    sensors = {"drive": {"type": "actuator", "measure": ["force", "pos"], "noise": {"pos": 0.1, "*": 0.2}}}
    model = compiled(measured(arm(), actuators=actuators, sensors=sensors))
    names = [model.sensor(index).name for index in range(model.nsensor)]
    assert names == ["arm_joint_force", "drive_arm_joint_force", "drive_arm_joint_pos"]
    np.testing.assert_allclose(model.sensor_noise, [0, 0.2, 0.2])


def test_force_and_torque_are_those_that_hold_the_link():
    """Its weight, and that of what hangs on it, about the frame; a fixed link has a body of its own then."""
    robot = arm()
    model = compiled(measured(robot, sensors={"load": {"type": "force_torque", "frame": "mount"}}))
    model.dof_armature[:] = 1e9
    data = forward(model)
    held = [model.body(name).id for name in ("hand", "eye")]
    mass = model.body_mass[held]
    assert mass.sum() == pytest.approx(sum(robot.link(name).inertial.mass for name in ("hand", "eye")))
    world_from_mount = site(data, "mount")
    weights = np.outer(mass, [0, 0, -GRAVITY])
    force = -weights.sum(axis=0)
    torque = -np.cross(data.xipos[held] - world_from_mount[:3, 3], weights).sum(axis=0)
    turned = world_from_mount[:3, :3].T
    np.testing.assert_allclose(read(data, "load_force"), turned @ force, atol=1e-6)
    np.testing.assert_allclose(read(data, "load_torque"), turned @ torque, atol=1e-6)


def test_a_force_sensor_of_the_source_keeps_its_body_too():
    robot = replace(arm(), sensors=(Sensor("load", "force", "site", "mount"),))
    model = compiled(measured(robot))
    assert model.body("hand").id > 0
    assert mujoco.mj_name2id(compiled(measured(arm())), mujoco.mjtObj.mjOBJ_BODY, "hand") == -1


def cube(touch, folder):
    """A cube that lies on the ground, after a second."""
    box = Primitive("box", (0.1, 0.1, 0.1), frozen(at(0.2, 0, 0)))
    robot = robot_with(
        fixed=False, shapes={"base": (box,)}, frames=(Frame("pad", "base", frozen(at(0.2, 0, 0)), ""),)
    )
    write(
        robot,
        folder,
        plan_of(
            sensors={"pad": touch, "far": {"type": "touch", "frame": "pad", "xyz": [0, 0, 1], "size": 0.01}}
        ),
        solid(robot),
    )
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    data = forward(model)
    for _ in range(1500):
        mujoco.mj_step(model, data)
    return model, data


@pytest.mark.parametrize(
    "keys", ["touch", {"type": "touch", "size": [0.2, 0.2, 0.2]}, {"type": "touch", "size": 0.2}], ids=str
)
def test_touch_reads_the_weight_on_the_ground(keys, tmp_path):
    model, data = cube(keys, tmp_path)
    assert read(data, "pad") == pytest.approx(model.body_subtreemass[1] * GRAVITY, rel=0.01)
    assert read(data, "far") == 0


def test_zone_of_a_touch_sensor_is_the_box_around_the_colliders():
    robot = arm()
    model = compiled(
        measured(robot, sensors={"pad": {"type": "touch", "frame": "mount", "rpy": [0.3, 0.2, 0.1]}})
    )
    data = forward(model)
    corners = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.1, 0.1) for z in (-0.15, 0.15)])
    world_from_hand = from_parts(data.body("arm").xmat.reshape(3, 3), data.body("arm").xpos) @ TILT
    world = (world_from_hand[:3, :3] @ (corners + np.array([0.01, 0.02, 0.03])).T).T + world_from_hand[:3, 3]
    inside = np.linalg.inv(site(data, "pad"))
    reach = np.abs(world @ inside[:3, :3].T + inside[:3, 3]).max(axis=0)
    np.testing.assert_allclose(model.site("pad").size, reach + 1e-3, atol=1e-4)


def test_rangefinder_reads_the_distance_of_the_ground(tmp_path):
    slope = 0.4
    robot = robot_with([joint("revolute", "base", "arm", place=at(0, 0, 0.8))])
    down = {"type": "rangefinder", "frame": "base", "xyz": [0, 0, 0.5], "rpy": [math.pi - slope, 0, 0]}
    up = {"type": "rangefinder", "frame": "base"}
    write(robot, tmp_path, plan_of(sensors={"down": down, "up": up}, scene__pose="given"), NO_MESHES)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    data = forward(model)
    assert read(data, "down") == pytest.approx(0.5 / math.cos(slope), abs=1e-9)
    assert read(data, "up") == -1


def test_frame_is_measured_in_the_world_or_in_another():
    quantities = ["pos", "quat", "xaxis", "yaxis", "zaxis", "linvel", "angvel"]
    sensors = {
        "alone": {"type": "frame", "frame": "mount", "measure": [*quantities, "linacc", "angacc"]},
        "eye": {"type": "frame", "relative_to": "arm", "measure": quantities},
    }
    model = compiled(measured(arm(), sensors=sensors))
    data = forward(model, arm_joint=0.7)
    mount = site(data, "mount")
    arm_, eye = (
        from_parts(data.body(name).xmat.reshape(3, 3), data.body(name).xpos) for name in ("arm", "eye")
    )
    for name, expected in (("alone", mount), ("eye", np.linalg.inv(arm_) @ eye)):
        np.testing.assert_allclose(read(data, f"{name}_pos"), expected[:3, 3], atol=1e-12)
        for column, axis in enumerate(("xaxis", "yaxis", "zaxis")):
            np.testing.assert_allclose(read(data, f"{name}_{axis}"), expected[:3, column], atol=1e-12)
        rotated = np.zeros(9)
        mujoco.mju_quat2Mat(rotated, read(data, f"{name}_quat"))
        np.testing.assert_allclose(rotated.reshape(3, 3), expected[:3, :3], atol=1e-12)
    axis, anchor = data.joint("arm_joint").xaxis, data.joint("arm_joint").xanchor
    np.testing.assert_allclose(read(data, "alone_angvel"), axis * 0.7, atol=1e-12)
    np.testing.assert_allclose(
        read(data, "alone_linvel"), np.cross(axis * 0.7, mount[:3, 3] - anchor), atol=1e-12
    )
    np.testing.assert_allclose(read(data, "eye_linvel"), 0, atol=1e-12)
    assert np.abs(read(data, "alone_linacc")).max() > 0.1
    assert len(read(data, "alone_angacc")) == 3


def test_camera_looks_along_z_and_projects_frames():
    camera = {"type": "camera", "frame": "mount", "rpy": [0.2, 0.1, 0], "fovy": 60, "resolution": [200, 100]}
    ahead = Frame("ahead", "hand", frozen(PLACE @ TILT @ turn_of(0.2, 0.1) @ at(0.3, 0.2, 2.0)), "")
    base = arm()
    robot = replace(base, frames=(*base.frames, ahead))
    model = compiled(measured(robot, sensors={"view": {**camera, "sees": ["ahead", "eye"]}}))
    assert (model.camera("view").fovy[0], model.cam_resolution[0].tolist()) == (60, [200, 100])
    data = forward(model)
    focal = 100 / 2 / math.tan(math.radians(30))
    np.testing.assert_allclose(read(data, "view_ahead"), [100 + focal * 0.15, 50 + focal * 0.1], atol=1e-4)
    assert len(read(data, "view_eye")) == 2


def turn_of(roll, pitch):
    """Roll, then pitch about fixed axes (4, 4)."""
    across, along = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    return from_parts(turn(across, pitch) @ turn(along, roll), np.zeros(3))


def test_lengths_and_angles_take_their_unit():
    mount = {"frame": "hand", "xyz": ["25 mm", 0, 0], "rpy": [0, 0, "90 deg"]}
    sensors = {
        "it": {"type": "touch", "size": "2 cm", **mount},
        "eye": {"type": "camera", "fovy": "1 rad", "frame": "hand"},
    }
    model = compiled(measured(arm(), sensors=sensors))
    assert model.site("it").size[0] == pytest.approx(0.02)
    assert model.camera("eye").fovy[0] == pytest.approx(math.degrees(1))
    table = json.loads(measured(arm(), sensors=sensors).files["robot.json"])["sensor_sites"][0]
    assert table["pose"]["xyz"] == [0.025, 0, 0]
    np.testing.assert_allclose(table["pose"]["quat"], [math.sqrt(0.5), 0, 0, math.sqrt(0.5)], atol=1e-11)


def test_noise_and_cutoff_of_lengths_and_angles_take_their_unit():
    sensors = {
        "it": {"type": "rangefinder", "frame": "hand", "cutoff": "400 cm"},
        "arm": {"type": "joint", "joints": "arm_joint", "noise": {"pos": "1 deg"}},
    }
    model = compiled(measured(arm(), sensors=sensors))
    assert model.sensor("it").cutoff[0] == pytest.approx(4)
    assert model.sensor("arm_pos").noise[0] == pytest.approx(math.radians(1))
    tree = plan_of(sensors=sensors).tree()
    assert (tree["sensors"]["arm"]["noise"], Plan.parse(tree).tree()) == ({"pos": "1 deg"}, tree)
    sensors["arm"]["noise"] = {"pos": "1 mm"}
    code, where, message, hint = problem(arm(), sensors)
    assert (code, where) == ("E-SENSOR", "sensors.arm")
    assert message == "noise of pos of arm_joint: '1 mm' is no angle"
    assert "deg" in hint


def test_noise_and_cutoff_are_in_the_model():
    keys = {"type": "imu", "frame": "mount", "noise": {"*": 0.01, "accelerometer": 0.05}, "cutoff": 0.3}
    model = compiled(measured(arm(), sensors={"imu": keys}))
    np.testing.assert_allclose(model.sensor_noise, [0.01, 0.05, 0.01])
    np.testing.assert_allclose(model.sensor_cutoff, [0.3, 0.3, 0])
    data = forward(model, arm_joint=10.0)
    assert np.abs(read(data, "imu_gyro")).max() == pytest.approx(0.3)


def test_robot_json_lists_sensors_with_their_places_and_cameras():
    sensors = {
        "imu": {"type": "imu", "frame": "hand", "measure": ["gyro"], "noise": 0.01},
        "pad": {"type": "touch", "frame": "hand", "size": 0.1},
        "view": {"type": "camera", "frame": "hand", "xyz": [0, 0, 0.1]},
    }
    table = json.loads(measured(arm(), sensors=sensors).files["robot.json"])
    on = {"kind": "site", "name": "hand"}
    expected = {
        "name": "imu_gyro", "type": "gyro", "on": on, "relative_to": None, "noise": 0.01, "cutoff": 0.0,
    }  # fmt: skip
    assert table["sensors"][0] == expected
    identity = {"xyz": [0.0, 0.0, 0.0], "quat": [1.0, 0.0, 0.0, 0.0]}
    assert table["sensor_sites"] == [
        {"name": "pad", "link": "hand", "pose": identity, "shape": "sphere", "size": [0.1]}
    ]
    assert table["cameras"][0]["pose"]["xyz"] == [0, 0, 0.1]
    assert "sensors" not in json.loads(measured(arm()).files["robot.json"])


def test_checks_pass_with_sensors_and_sites_have_free_names(tmp_path):
    base = arm()
    closed = loop("ball", "arm", "base", np.eye(4), PLACE, name="close")
    robot = robot_with(base.joints[:1], loops=(closed,))
    plan = plan_of(sensors={"close_a": {"type": "imu", "frame": "arm"}, "base": "imu"})
    outcome = write(robot, tmp_path, plan)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    names = [model.site(index).name for index in range(model.nsite)]
    assert len(set(names)) == len(names) == 4
    checks = validate(tmp_path, outcome.written, plan)
    assert [check.name for check in checks if check.fails] == []


def test_a_sensor_of_the_source_keeps_its_name():
    robot = replace(arm(), sensors=(Sensor("arm_joint_pos", "jointpos", "joint", "arm_joint"),))
    actuators = {"arm_joint": {"type": "motor", "encoder": True}}
    code, where, message, _ = problem(robot, {}, actuators=actuators)
    assert (code, where) == ("E-SENSOR", "actuators.arm_joint.encoder")
    assert "'arm_joint_pos' is there already, from the source" in message
    model = compiled(measured(robot, sensors={"imu": {"type": "imu", "frame": "mount"}}))
    assert [model.sensor(index).name for index in range(2)] == ["arm_joint_pos", "imu_gyro"]


if __name__ == "__main__":
    made = {
        title: {"keys": golden["keys"], "elements": elements(of_golden(golden["keys"]))}
        for title, golden in GOLDEN.items()
    }
    FILE.write_text(yaml.safe_dump(made, sort_keys=False, width=200), encoding="utf-8")
