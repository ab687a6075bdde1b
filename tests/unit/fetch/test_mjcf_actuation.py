"""Actuators and sensors of an MJCF are in the exported MJCF, and the robot answers to them as it did."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.stages.export import Exported, export
from linkwright.stages.fetch.mjcf.gather import gather
from linkwright.stages.graph import build_robot
from linkwright.stages.robot.model.robot import Robot
from tests.support.building import NO_MESHES, plan_of
from tests.support.mjcfs import model, written

pytestmark = pytest.mark.usefixtures("guests_at_home")

OPTION = '<option integrator="implicitfast" timestep="0.002"/>'
SOLID = '<inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.02 0.02"/>'
ACTUATORS = """<actuator>
  <velocity name="spin" joint="c" kv="0.7" ctrlrange="-4 4"/>
  <motor name="push" joint="a" gear="10" ctrlrange="-2 2"/>
  <position joint="b" kp="30" kv="2" forcerange="-3 5" ctrlrange="-1 1"/>
  <general name="lag" joint="d" dyntype="filter" dynprm="0.1" gainprm="3" biastype="affine"
    biasprm="0.5 -3 -1"/>
  <general name="bent" joint="e" gaintype="affine" gainprm="1 2 0.5" forcerange="-9 9"/>
  <intvelocity name="creep" joint="f" kp="20" kv="1" actrange="-1 1" ctrlrange="-2 2"/>
  <motor name="again" joint="a" gear="-3"/>
</actuator>"""
SENSORS = """<sensor>
  <gyro name="imu" site="tip" noise="0.01" cutoff="30"/><accelerometer site="tip"/>
  <jointpos name="angle" joint="b"/><jointvel joint="c"/><jointactuatorfrc name="torque" joint="a"/>
  <actuatorfrc name="effort" actuator="push"/><actuatorpos actuator="spin"/>
  <framepos name="place" objtype="xbody" objname="link_f" reftype="site" refname="tip"/>
  <framequat objtype="body" objname="link_c"/><subtreecom name="com" body="base"/><clock name="time"/>
  <force name="load" site="tip"/>
</sensor>"""


def text(more: str = ACTUATORS + SENSORS) -> str:
    """A chain of six hinges, a to f, on a base with the site `tip`."""
    links = ""
    for name in reversed("abcdef"):
        joint = f'<joint name="{name}" axis="0 1 0" damping="0.2" armature="0.01"/>'
        links = f'<body name="link_{name}" pos="0.2 0 0">{joint}{SOLID}{links}</body>'
    base = f'<body name="base">{SOLID}<site name="tip" pos="0 0 0.1"/>{links}</body>'
    return model(base, OPTION + more)


def robot_of(path: Path, **keys: object) -> Robot:
    plan = plan_of(source={"kind": "mjcf", "path": str(path)}, root={"base": "fixed"}, **keys)
    return build_robot(gather(plan.source)[0], plan)


def exported(path: Path, **keys: object) -> Exported:
    plan = plan_of(source={"kind": "mjcf", "path": str(path)}, root={"base": "fixed"}, **keys)
    return export(build_robot(gather(plan.source)[0], plan), NO_MESHES, plan)


def compiled(found: Exported) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(found.files["robot.xml"].decode())


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return written(tmp_path, text())


def test_each_actuator_has_its_parameters_and_its_place(path: Path) -> None:
    was, now = mujoco.MjModel.from_xml_path(str(path)), compiled(exported(path))
    assert now.nu == was.nu == 7
    names = [now.actuator(index).name for index in range(now.nu)]
    assert names == ["spin", "push", "b", "lag", "bent", "creep", "again"]
    for field in ("gainprm", "biasprm", "dynprm", "gaintype", "biastype", "dyntype", "gear", "actlimited"):
        mine, theirs = getattr(now, f"actuator_{field}"), getattr(was, f"actuator_{field}")
        np.testing.assert_allclose(mine, theirs, rtol=1e-12, err_msg=field)
    for field in ("ctrllimited", "ctrlrange", "forcelimited", "forcerange", "actrange"):
        np.testing.assert_allclose(getattr(now, f"actuator_{field}"), getattr(was, f"actuator_{field}"))


def test_each_sensor_measures_the_same(path: Path) -> None:
    was, now = mujoco.MjModel.from_xml_path(str(path)), compiled(exported(path))
    for field in ("type", "noise", "cutoff", "dim"):
        assert list(getattr(now, f"sensor_{field}")) == list(getattr(was, f"sensor_{field}"))
    assert [now.sensor(i).name for i in range(now.nsensor)][:4] == [
        *("imu", "tip_accelerometer", "angle", "c_jointvel"),
    ]


def test_it_moves_and_measures_as_it_did_under_any_controls(path: Path) -> None:
    models = mujoco.MjModel.from_xml_path(str(path)), compiled(exported(path))
    random = np.random.default_rng(3)
    datas = [mujoco.MjData(one) for one in models]
    for _ in range(200):
        controls = random.uniform(-1, 1, models[0].nu)
        for one, data in zip(models, datas, strict=True):
            data.ctrl[:] = controls
            mujoco.mj_step(one, data)
    was, now = datas
    assert np.abs(was.qpos).max() > 0.1
    np.testing.assert_allclose(now.qpos, was.qpos, atol=1e-9)
    np.testing.assert_allclose(now.actuator_force, was.actuator_force, atol=1e-7)
    np.testing.assert_allclose(now.sensordata, was.sensordata, atol=1e-6)


def test_an_entry_that_only_measures_keeps_the_actuators_of_the_file(path: Path) -> None:
    bare, found = exported(path), exported(path, actuators={"*": {"encoder": True}, "a": {"force": True}})
    assert found.written.actuation == bare.written.actuation
    model = compiled(found)
    added = [model.sensor(i).name for i in range(compiled(bare).nsensor, model.nsensor)]
    names = [model.actuator(i).name for i in range(model.nu)]
    expected = [(f"{name}_pos", f"{name}_vel") for name in names]
    assert [name for name in added if not name.endswith("_force")] == [
        one for pair in expected for one in pair
    ]
    assert [name for name in added if name.endswith("_force")] == ["push_force", "again_force"]


ZONES = {"sphere": "0.03", "capsule": "0.02 0.05", "ellipsoid": "0.1 0.2 0.3", "cylinder": "0.02 0.05"} | {
    "box": "0.1 0.2 0.3"
}


@pytest.mark.parametrize("shape", ZONES)
def test_a_touch_sensor_feels_in_the_same_shape_at_the_same_place(tmp_path: Path, shape: str) -> None:
    zone = f'<site name="sole" pos="0.1 0.2 0.3" quat="1 2 3 4" type="{shape}" size="{ZONES[shape]}"/>'
    tree = text('<sensor><touch name="press" site="sole"/><gyro site="sole"/></sensor>')
    path = written(tmp_path, tree.replace('<site name="tip"', f'{zone}<site name="tip"'))
    was, now = mujoco.MjModel.from_xml_path(str(path)), compiled(exported(path))
    old, new = was.site("sole"), now.site(int(now.sensor("press").objid[0]))
    assert now.site(int(now.sensor(1).objid[0])).name == "sole"
    assert (new.type[0], now.body(int(new.bodyid[0])).name) == (old.type[0], "base")
    used = len(ZONES[shape].split())
    np.testing.assert_allclose(new.size[:used], old.size[:used], rtol=1e-12)
    np.testing.assert_allclose(new.pos, old.pos, atol=1e-12)
    np.testing.assert_allclose(np.abs(new.quat @ old.quat), 1.0, atol=1e-12)


def test_renamed_joints_and_links_keep_theirs(path: Path) -> None:
    names = {"joints": {"b": "elbow"}, "links": {"link_f": "hand"}}
    model = compiled(exported(path, names=names))
    servo = model.actuator("b")
    assert model.joint(int(servo.trnid[0])).name == "elbow"
    assert model.joint(int(model.sensor("angle").objid[0])).name == "elbow"
    assert model.body(int(model.sensor("place").objid[0])).name == "hand"


def test_star_none_takes_them_out_and_sensors_of_them_too(path: Path) -> None:
    model = compiled(exported(path, actuators={"*": "none"}))
    assert model.nu == 0
    names = {model.sensor(i).name for i in range(model.nsensor)}
    assert {"angle", "imu"} <= names
    assert not {"effort", "spin_actuatorpos"} & names


def test_one_is_taken_out_or_replaced_and_the_others_stay(path: Path) -> None:
    model = compiled(exported(path, actuators={"c": "none"}))
    assert [model.actuator(i).name for i in range(model.nu)] == ["push", "b", "lag", "bent", "creep", "again"]
    model = compiled(exported(path, actuators={"a": {"type": "position", "kp": 44}}))
    names = [model.actuator(i).name for i in range(model.nu)]
    assert names == ["spin", "b", "lag", "bent", "creep", "a"]
    assert model.actuator("a").gainprm[0] == 44


def test_a_new_actuator_gets_a_name_that_no_other_has(tmp_path: Path) -> None:
    other = '<actuator><motor name="a" joint="b"/></actuator>'
    model = compiled(exported(written(tmp_path, text(other)), actuators={"a": "motor"}))
    assert [model.actuator(i).name for i in range(model.nu)] == ["a", "a_2"]


def test_at_home_each_joint_is_held_as_far_as_its_actuators_can(path: Path) -> None:
    """The forces of the compiled actuators against the weight: of two on one joint the first one holds it."""
    robot = robot_of(path)
    assert [one.dof for one in robot.actuators] == ["c", "a", "b", "d", "e", "f", "a"]
    found = exported(path)
    assert found.written.actuation is not None
    homes = {one.name: one.home for one in found.written.actuation.actuators}
    assert homes["spin"] == homes["bent"] == homes["creep"] == homes["again"] == 0
    assert found.advice == ""
    model = compiled(found)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    weight = {name: data.qfrc_bias[model.joint(name).dofadr[0]] for name in "abcdef"}
    force = {name: data.qfrc_actuator[model.joint(name).dofadr[0]] for name in "abcdef"}
    assert {name: force[name] for name in "df"} == pytest.approx(
        {name: weight[name] for name in "df"}, rel=1e-9
    )
    # At the ends of their ranges: 10 times a control of -2, and a force of -3.
    assert (force["a"], force["b"]) == pytest.approx((max(weight["a"], -20), max(weight["b"], -3)), rel=1e-9)
    assert weight["b"] < -3


@pytest.mark.skipif(not hasattr(mujoco.mjtDyn, "mjDYN_PID"), reason="needs a MuJoCo with such actuators")
def test_an_actuator_that_is_lost_is_a_warning(tmp_path: Path) -> None:
    lost = """<actuator><pid name="hold" joint="a" kp="3" ki="1"/><motor name="stay" joint="b" group="3"/>
      </actuator><sensor><actuatorfrc name="of_hold" actuator="hold"/></sensor>"""
    robot = robot_of(written(tmp_path, text(lost)))
    assert [one.name for one in robot.actuators] == ["stay"]
    assert robot.sensors == ()
    told = {one.code: one.message for one in robot.diagnostics}
    assert "1 × actuator (hold)" in told["W-MJCF-LEFT"]
    assert "1 × sensor (of_hold)" in told["I-MJCF-LEFT"]
    assert "stay" not in "".join(told.values())


def test_an_exported_file_read_again_gives_the_same_file(path: Path, tmp_path: Path) -> None:
    first = exported(path).files["robot.xml"]
    (tmp_path / "again").mkdir()
    (tmp_path / "again" / "robot.xml").write_bytes(first)
    second = exported(tmp_path / "again" / "robot.xml").files["robot.xml"]
    parts = [data[data.index(b"<actuator>") : data.index(b"<keyframe>")] for data in (first, second)]
    assert parts[0] == parts[1]
