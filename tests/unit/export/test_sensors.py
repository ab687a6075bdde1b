"""The key `sensors`: what measures the robot, and what the compiled model measures."""

import itertools
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
from linkwright.stages.mujoco.names import OBJ
from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.poses import from_parts, rotation_from_quat, rotation_from_rpy
from linkwright.stages.robot.model.robot import Frame, Limits, Primitive, Sensor, frozen
from tests.support.building import NO_MESHES, plan_of, solid, write
from tests.support.exports import compiled, exported, failing
from tests.support.mjcfs import body, rebuilt, written
from tests.support.mjcfs import model as mjcf
from tests.support.robots import at, joint, loop, pose, robot_with
from tests.support.states import pose_of, run, state
from tests.support.touching import box

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


def measured(robot, **keys):
    """The export of a robot with its colliders."""
    return exported(robot, solid(robot), **keys)


def forward(model, **speeds):
    """The state at the keyframe `home` with these speeds of joints."""
    data = state(model, "home")
    for name, speed in speeds.items():
        data.joint(name).qvel[0] = speed
    mujoco.mj_forward(model, data)
    return data


def read(data, name):
    return np.array(data.sensor(name).data)


def near(actual, expected, tolerance=1e-12):
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance)


def names_of(model):
    return [model.sensor(index).name for index in range(model.nsensor)]


def problem(robot, sensors, **keys):
    with pytest.raises(ExportError) as error:
        measured(robot, sensors=sensors, **keys)
    (only,) = error.value.problems
    return only.code, only.where, only.message, only.hint


def elements(outcome):
    """The sites, cameras and sensors of a model that the bare robot does not have, as text."""
    root = parse(outcome.files["robot.xml"])
    sensors = [node for section in root.iterchildren("sensor") for node in section]
    places = [node for node in root.iter("site", "camera") if node.get("name") not in ("mount", "hand")]
    return [
        " ".join([node.tag, *(f"{key}={value}" for key, value in node.items())]) for node in places + sensors
    ]


def of_golden(keys):
    return measured(arm(), **({"actuators": {"arm_joint": {"type": "motor"}}} | keys))


@pytest.mark.parametrize("title", GOLDEN)
def test_each_option_comes_to_its_golden_and_compiles(title):
    keys, expected = GOLDEN[title]["keys"], GOLDEN[title]["elements"]
    outcome = of_golden(keys)
    assert elements(outcome) == expected, "if this is meant: python -m tests.unit.export.test_sensors"
    sensors = [text for text in expected if not text.startswith(("site ", "camera "))]
    assert names_of(compiled(outcome)) == [text.split("name=")[1].split()[0] for text in sensors]
    assert outcome.files["robot.urdf"] == of_golden({}).files["robot.urdf"]


def test_types_measurements_and_options_have_goldens():
    goldens = [(row["keys"].get("sensors", {}), row["elements"]) for row in GOLDEN.values()]
    entries = [(entry, elements) for sensors, elements in goldens for entry in sensors.values()]
    for kind, measures in MEASURES.items():
        tags = {text.split()[0] for entry, texts in entries if entry["type"] == kind for text in texts}
        assert set(measures.values()) <= tags, kind
    assert {key for entry, _ in entries for key in entry} == set(SensorSection.model_fields)


def test_accelerometer_at_rest_reads_gravity_upwards():
    imu = {"type": "imu", "frame": "mount", "xyz": [0.1, 0, 0], "rpy": [1, 2, 3]}
    model = compiled(measured(arm(), sensors={"imu": imu}))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EQUALITY
    model.dof_damping[:] = model.dof_armature[:] = 1e9  # holds it still
    data = forward(model)
    world_from_imu = pose_of(data.site("imu"))
    near(read(data, "imu_accelerometer"), world_from_imu[:3, :3].T @ [0, 0, GRAVITY], 1e-6)
    offset = np.linalg.inv(pose_of(data.site("mount"))) @ world_from_imu
    near(offset[:3, 3], [0.1, 0, 0])
    near(rotation_from_quat(read(data, "imu_quat")), world_from_imu[:3, :3])


def test_gyro_and_velocimeter_read_the_motion_of_a_joint():
    measure = ["gyro", "velocimeter", "magnetometer"]
    model = compiled(measured(arm(), sensors={"mount": {"type": "imu", "measure": measure}}))
    data = forward(model, arm_joint=0.7)
    axis, anchor = data.joint("arm_joint").xaxis, data.joint("arm_joint").xanchor
    world_from_mount = pose_of(data.site("mount"))
    turned, away = world_from_mount[:3, :3], world_from_mount[:3, 3] - anchor
    near(read(data, "mount_gyro"), turned.T @ axis * 0.7)
    near(read(data, "mount_velocimeter"), turned.T @ np.cross(axis * 0.7, away))
    near(read(data, "mount_magnetometer"), turned.T @ model.opt.magnetic)


def test_sensors_of_joints_read_their_values():
    quantities = ["pos", "vel", "actuator_force", "limit_pos", "limit_vel", "limit_force"]
    both = {"type": "joint", "measure": quantities}
    sensors = {"all": both, "one": {"type": "joint", "joints": "arm_joint"}}
    model = compiled(measured(arm(), sensors=sensors, actuators={"*": "motor"}))
    data = forward(model, arm_joint=0.4)
    data.joint("arm_joint").qpos[0], data.ctrl[0] = 1.1, 0.3
    mujoco.mj_forward(model, data)
    expected = {"pos": 1.1, "vel": 0.4, "actuator_force": 0.3, "limit_pos": -0.1, "limit_vel": -0.4}
    for name, value in expected.items():
        assert read(data, f"all_arm_joint_{name}") == pytest.approx(value), name
    assert read(data, "all_arm_joint_limit_force") > 0
    near(read(data, "all_eye_joint_pos"), [1, 0, 0, 0])
    assert len(read(data, "all_eye_joint_vel")) == 3
    assert (read(data, "one_pos"), read(data, "one_vel")) == (1.1, 0.4)
    assert "all_eye_joint_limit_pos" not in names_of(model)


def test_encoder_and_force_sensor_of_an_actuator_by_glob():
    actuators = {"*": {"type": "position", "kp": 50, "kv": 3, "gear": 2, "encoder": True, "force": True}}
    model = compiled(measured(arm(), actuators=actuators))
    data = forward(model, arm_joint=0.2)
    data.joint("arm_joint").qpos[0], data.ctrl[0] = 0.5, 0.7
    mujoco.mj_forward(model, data)
    assert names_of(model) == ["arm_joint_pos", "arm_joint_vel", "arm_joint_force"]
    assert data.sensordata == pytest.approx([2 * 0.5, 2 * 0.2, 50 * (0.7 - 1.0) - 3 * 0.4])


def test_entry_that_only_measures_drives_nothing():
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
    assert names_of(model) == ["arm_joint_force", "drive_arm_joint_force", "drive_arm_joint_pos"]
    near(model.sensor_noise, [0, 0.2, 0.2])


def test_force_and_torque_are_those_that_hold_the_link():
    """Its weight, and that of what hangs on it, about the frame; a fixed link has a body of its own then."""
    robot = arm()
    model = compiled(measured(robot, sensors={"load": {"type": "force_torque", "frame": "mount"}}))
    model.dof_armature[:] = 1e9
    data = forward(model)
    held = [model.body(name).id for name in ("hand", "eye")]
    mass = model.body_mass[held]
    assert mass.sum() == pytest.approx(sum(robot.link(name).inertial.mass for name in ("hand", "eye")))
    world_from_mount = pose_of(data.site("mount"))
    weights = np.outer(mass, [0, 0, -GRAVITY])
    torque = -np.cross(data.xipos[held] - world_from_mount[:3, 3], weights).sum(axis=0)
    near(read(data, "load_force"), world_from_mount[:3, :3].T @ -weights.sum(axis=0), 1e-6)
    near(read(data, "load_torque"), world_from_mount[:3, :3].T @ torque, 1e-6)
    sensed = replace(robot, sensors=(Sensor("load", "force", "site", "mount"),))
    bodies = [mujoco.mj_name2id(compiled(measured(r)), OBJ.mjOBJ_BODY, "hand") for r in (sensed, robot)]
    assert (bodies[0] > 0, bodies[1]) == (True, -1), "so it has for a sensor of the source"


def cube(touch, folder):
    """A cube that lies on the ground, after three seconds."""
    frames = (Frame("pad", "base", frozen(at(0.2, 0, 0)), ""),)
    robot = robot_with(fixed=False, shapes={"base": (box(0.1, 0.1, 0.1, at(0.2, 0, 0)),)}, frames=frames)
    far = {"type": "touch", "frame": "pad", "xyz": [0, 0, 1], "size": 0.01}
    write(robot, folder, plan_of(sensors={"pad": touch, "far": far}), solid(robot))
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    return model, run(model, forward(model), 3.0)


@pytest.mark.parametrize(
    "keys", ["touch", {"type": "touch", "size": [0.2, 0.2, 0.2]}, {"type": "touch", "size": 0.2}], ids=str
)
def test_touch_reads_the_weight_on_the_ground(keys, tmp_path):
    model, data = cube(keys, tmp_path)
    assert read(data, "pad") == pytest.approx(model.body_subtreemass[1] * GRAVITY, rel=0.01)
    assert read(data, "far") == 0


def test_zone_of_a_touch_sensor_is_the_box_around_the_colliders():
    pad = {"type": "touch", "frame": "mount", "rpy": [0.3, 0.2, 0.1]}
    model = compiled(measured(arm(), sensors={"pad": pad}))
    data = forward(model)
    sides = itertools.product((-0.05, 0.05), (-0.1, 0.1), (-0.15, 0.15))
    corners = np.array(list(sides)) + np.array([0.01, 0.02, 0.03])
    pad_from_hand = np.linalg.inv(pose_of(data.site("pad"))) @ pose_of(data.body("arm")) @ TILT
    reach = np.abs(corners @ pad_from_hand[:3, :3].T + pad_from_hand[:3, 3]).max(axis=0)
    near(model.site("pad").size, reach + 1e-3, 1e-4)


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
    data = forward(compiled(measured(arm(), sensors=sensors)), arm_joint=0.7)
    mount, arm_from_world = pose_of(data.site("mount")), np.linalg.inv(pose_of(data.body("arm")))
    for name, expected in (("alone", mount), ("eye", arm_from_world @ pose_of(data.body("eye")))):
        near(read(data, f"{name}_pos"), expected[:3, 3])
        for column, axis in enumerate(("xaxis", "yaxis", "zaxis")):
            near(read(data, f"{name}_{axis}"), expected[:3, column])
        near(rotation_from_quat(read(data, f"{name}_quat")), expected[:3, :3])
    axis, anchor = data.joint("arm_joint").xaxis, data.joint("arm_joint").xanchor
    near(read(data, "alone_angvel"), axis * 0.7)
    near(read(data, "alone_linvel"), np.cross(axis * 0.7, mount[:3, 3] - anchor))
    near(read(data, "eye_linvel"), 0)
    assert np.abs(read(data, "alone_linacc")).max() > 0.1
    assert len(read(data, "alone_angacc")) == 3


def test_camera_looks_along_z_and_projects_frames():
    camera = {"type": "camera", "frame": "mount", "rpy": [0.2, 0.1, 0], "fovy": 60, "resolution": [200, 100]}
    turned = from_parts(rotation_from_rpy((0.2, 0.1, 0.0)), np.zeros(3))
    ahead = Frame("ahead", "hand", frozen(PLACE @ TILT @ turned @ at(0.3, 0.2, 2.0)), "")
    base = arm()
    robot = replace(base, frames=(*base.frames, ahead))
    model = compiled(measured(robot, sensors={"view": {**camera, "sees": ["ahead", "eye"]}}))
    assert (model.camera("view").fovy[0], model.cam_resolution[0].tolist()) == (60, [200, 100])
    data = forward(model)
    focal = 100 / 2 / math.tan(math.radians(30))
    near(read(data, "view_ahead"), [100 + focal * 0.15, 50 + focal * 0.1], 1e-4)
    assert len(read(data, "view_eye")) == 2


def test_lengths_and_angles_take_their_unit():
    sensors = {
        "it": {
            "type": "touch",
            "size": "2 cm",
            "frame": "hand",
            "xyz": ["25 mm", 0, 0],
            "rpy": [0, 0, "90 deg"],
        },
        "eye": {"type": "camera", "fovy": "1 rad", "frame": "hand"},
        "range": {"type": "rangefinder", "frame": "hand", "cutoff": "400 cm"},
        "arm": {"type": "joint", "joints": "arm_joint", "noise": {"pos": "1 deg"}},
    }
    outcome = measured(arm(), sensors=sensors)
    model = compiled(outcome)
    assert model.site("it").size[0] == pytest.approx(0.02)
    assert model.camera("eye").fovy[0] == pytest.approx(math.degrees(1))
    pose = json.loads(outcome.files["robot.json"])["sensor_sites"][0]["pose"]
    assert pose["xyz"] == [0.025, 0, 0]
    near(pose["quat"], [math.sqrt(0.5), 0, 0, math.sqrt(0.5)], 1e-11)
    assert model.sensor("range").cutoff[0] == pytest.approx(4)
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
    near(model.sensor_noise, [0.01, 0.05, 0.01])
    near(model.sensor_cutoff, [0.3, 0.3, 0])
    assert np.abs(read(forward(model, arm_joint=10.0), "imu_gyro")).max() == pytest.approx(0.3)


def test_robot_json_lists_sensors_with_their_places_and_cameras():
    sensors = {
        "imu": {"type": "imu", "frame": "hand", "measure": ["gyro"], "noise": 0.01},
        "pad": {"type": "touch", "frame": "hand", "size": 0.1},
        "view": {"type": "camera", "frame": "hand", "xyz": [0, 0, 0.1]},
    }
    table = json.loads(measured(arm(), sensors=sensors).files["robot.json"])
    on, here = {"kind": "site", "name": "hand"}, {"xyz": [0.0, 0.0, 0.0], "quat": [1.0, 0.0, 0.0, 0.0]}
    gyro = {"name": "imu_gyro", "type": "gyro", "on": on, "relative_to": None, "noise": 0.01, "cutoff": 0.0}
    pad = {"name": "pad", "link": "hand", "pose": here, "shape": "sphere", "size": [0.1]}
    assert (table["sensors"][0], table["sensor_sites"]) == (gyro, [pad])
    assert table["cameras"][0]["pose"]["xyz"] == [0, 0, 0.1]
    assert "sensors" not in json.loads(measured(arm()).files["robot.json"])


def test_checks_pass_with_sensors_and_sites_have_free_names(tmp_path):
    closed = loop("ball", "arm", "base", np.eye(4), PLACE, name="close")
    robot = robot_with(arm().joints[:1], loops=(closed,))
    plan = plan_of(sensors={"close_a": {"type": "imu", "frame": "arm"}, "base": "imu"})
    outcome = write(robot, tmp_path, plan)
    model = compiled(outcome)
    assert model.nsite == len({model.site(index).name for index in range(model.nsite)}) == 4
    assert failing(tmp_path, outcome, plan) == []


def test_sensor_of_the_source_keeps_its_name():
    robot = replace(arm(), sensors=(Sensor("arm_joint_pos", "jointpos", "joint", "arm_joint"),))
    actuators = {"arm_joint": {"type": "motor", "encoder": True}}
    code, where, message, _ = problem(robot, {}, actuators=actuators)
    assert (code, where) == ("E-SENSOR", "actuators.arm_joint.encoder")
    assert "'arm_joint_pos' is there already, from the source" in message
    model = compiled(measured(robot, sensors={"imu": {"type": "imu", "frame": "mount"}}))
    assert names_of(model)[:2] == ["arm_joint_pos", "imu_gyro"]


TENDON = """<tendon><fixed name="cable"><joint joint="lift" coef="1"/></fixed></tendon>
<sensor><tendonpos name="imu_gyro" tendon="cable"/></sensor>"""


@pytest.mark.parametrize(("sensor", "words"), [
    ({"imu": {"type": "imu", "frame": "arm"}}, "'imu_gyro' is there already, from the source"),
    ({"wrist": {"type": "camera", "frame": "arm"}}, "a camera 'wrist' already, in the source"),
    ({"overview": {"type": "camera", "frame": "arm"}}, "a camera 'overview' already, in scene.xml"),
])  # fmt: skip
def test_name_that_only_the_mjcf_has_is_taken(sensor, words, tmp_path):
    inside = '<joint name="lift" axis="0 1 0"/><camera name="wrist"/>'
    path = written(tmp_path, mjcf(body("arm", inside, pos="0 0 1"), TENDON))
    with pytest.raises(ExportError) as refused:
        rebuilt(path, sensors=sensor)
    (problem,) = refused.value.problems
    assert problem.code == "E-SENSOR"
    assert words in problem.message


def test_site_of_a_sensor_has_another_name_than_a_site_of_the_scene(tmp_path):
    cup = body("cup", '<freejoint/><site name="balance"/>', pos="1 0 1")
    world = cup + body("arm", '<joint name="lift" axis="0 1 0"/>', pos="0 0 1")
    files = rebuilt(
        written(tmp_path, mjcf(world)), sensors={"balance": {"type": "imu", "frame": "arm"}}
    ).files
    model = mujoco.MjModel.from_xml_string(files["scene.xml"].decode(), files)
    assert model.site("balance_2").bodyid == model.body("arm").id


if __name__ == "__main__":
    made = {
        title: {"keys": golden["keys"], "elements": elements(of_golden(golden["keys"]))}
        for title, golden in GOLDEN.items()
    }
    FILE.write_text(yaml.safe_dump(made, sort_keys=False, width=200), encoding="utf-8")
