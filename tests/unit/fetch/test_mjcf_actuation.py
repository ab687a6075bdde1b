"""Actuators and sensors of an MJCF are in the exported MJCF, and the robot answers to them as it did."""

import mujoco
import numpy as np
import pytest

from linkwright.stages.fetch.mjcf.compiled.effort import efforts
from tests.support.exports import compiled
from tests.support.mjcfs import model, rebuilt, robot_of, written

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


def text(more=ACTUATORS + SENSORS):
    """A chain of six hinges, a to f, on a base with the site `tip`."""
    links = ""
    for name in reversed("abcdef"):
        joint = f'<joint name="{name}" axis="0 1 0" damping="0.2" armature="0.01"/>'
        links = f'<body name="link_{name}" pos="0.2 0 0">{joint}{SOLID}{links}</body>'
    base = f'<body name="base">{SOLID}<site name="tip" pos="0 0 0.1"/>{links}</body>'
    return model(base, OPTION + more)


@pytest.fixture
def path(tmp_path):
    return written(tmp_path, text())


def names_of(model, kind, count):
    return [getattr(model, kind)(index).name for index in range(count)]


def test_actuator_without_a_gear_stays_in_the_mjcf_alone(tmp_path):
    servo = '<actuator><position name="idle" joint="a" kp="10" gear="0"/></actuator>'
    path = written(tmp_path, text(servo))
    assert robot_of(path).actuators == ()
    now = compiled(rebuilt(path))
    assert names_of(now, "actuator", now.nu) == ["idle"]
    assert now.actuator_gear[0][0] == 0


def test_actuators_and_sensors_have_their_parameters(path):
    was, now = mujoco.MjModel.from_xml_path(str(path)), compiled(rebuilt(path))
    assert names_of(now, "actuator", now.nu) == ["spin", "push", "b", "lag", "bent", "creep", "again"]
    for field in (
        *("gainprm", "biasprm", "dynprm", "gaintype", "biastype", "dyntype", "gear", "actlimited"),
        *("ctrllimited", "ctrlrange", "forcelimited", "forcerange", "actrange"),
    ):
        ours, theirs = getattr(now, f"actuator_{field}"), getattr(was, f"actuator_{field}")
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, err_msg=field)
    for field in ("type", "noise", "cutoff", "dim"):
        assert list(getattr(now, f"sensor_{field}")) == list(getattr(was, f"sensor_{field}"))
    assert names_of(now, "sensor", 4) == ["imu", "tip_accelerometer", "angle", "c_jointvel"]


def test_parameters_that_are_zero_stay_zero(tmp_path):
    spring = '<general name="spring" joint="a" gainprm="0" biastype="affine" biasprm="0.5 -3 -1"/>'
    lag = '<general name="lag" joint="b" dyntype="filter" dynprm="0" gainprm="3"/>'
    now = compiled(rebuilt(written(tmp_path, text(f"<actuator>{spring}{lag}</actuator>"))))
    assert (now.actuator_gainprm[0][0], now.actuator_dynprm[1][0]) == (0, 0)


def test_infinite_ranges_without_effect_are_read(tmp_path):
    servo = '<position joint="a" kp="1" ctrllimited="false" ctrlrange="-inf inf"/>'
    assert robot_of(written(tmp_path, text(f"<actuator>{servo}</actuator>"))).actuators[0].control is None


def test_an_actuator_of_the_worlds_tendon_is_of_the_scene(tmp_path):
    sites = '<site name="low" pos="0 0 1"/><site name="high" pos="0 0 2"/>'
    tendon = '<tendon><spatial name="rope"><site site="low"/><site site="high"/></spatial></tendon>'
    actuators = '<actuator><general name="winch" tendon="rope"/><motor name="push" joint="a"/></actuator>'
    path = written(tmp_path, text(tendon + actuators).replace("<worldbody>", f"<worldbody>{sites}"))
    assert [actuator.name for actuator in robot_of(path).actuators] == ["push"]


def test_an_actuator_without_a_gear_adds_no_force():
    actuators = '<motor joint="a" gear="0"/><motor joint="a" forcerange="-3 3"/>'
    model = mujoco.MjModel.from_xml_string(text(f"<actuator>{actuators}</actuator>"))
    assert efforts(model) == {0: 3.0}


def test_the_robot_moves_and_measures_as_it_did(path):
    models = mujoco.MjModel.from_xml_path(str(path)), compiled(rebuilt(path))
    random = np.random.default_rng(3)
    datas = [mujoco.MjData(model) for model in models]
    for _ in range(200):
        controls = random.uniform(-1, 1, models[0].nu)
        for moved, data in zip(models, datas, strict=True):
            data.ctrl[:] = controls
            mujoco.mj_step(moved, data)
    was, now = datas
    assert np.abs(was.qpos).max() > 0.1
    np.testing.assert_allclose(now.qpos, was.qpos, atol=1e-9)
    np.testing.assert_allclose(now.actuator_force, was.actuator_force, atol=1e-7)
    np.testing.assert_allclose(now.sensordata, was.sensordata, atol=1e-6)


def test_an_entry_that_only_measures_keeps_actuators(path):
    bare, outcome = rebuilt(path), rebuilt(path, actuators={"*": {"encoder": True}, "a": {"force": True}})
    assert outcome.written.actuation == bare.written.actuation
    model = compiled(outcome)
    added = names_of(model, "sensor", model.nsensor)[compiled(bare).nsensor :]
    names = names_of(model, "actuator", model.nu)
    encoders = [f"{name}_{quantity}" for name in names for quantity in ("pos", "vel")]
    assert [name for name in added if not name.endswith("_force")] == encoders
    assert [name for name in added if name.endswith("_force")] == ["push_force", "again_force"]


BLOCK, LONG = "0.1 0.2 0.3", "0.02 0.05"
ZONES = {"sphere": "0.03", "capsule": LONG, "ellipsoid": BLOCK, "cylinder": LONG, "box": BLOCK}


@pytest.mark.parametrize("shape", ZONES)
def test_a_touch_sensor_keeps_its_shape_and_place(tmp_path, shape):
    zone = f'<site name="sole" pos="0.1 0.2 0.3" quat="1 2 3 4" type="{shape}" size="{ZONES[shape]}"/>'
    tree = text('<sensor><touch name="press" site="sole"/><gyro site="sole"/></sensor>')
    path = written(tmp_path, tree.replace('<site name="tip"', f'{zone}<site name="tip"'))
    was, now = mujoco.MjModel.from_xml_path(str(path)), compiled(rebuilt(path))
    old, new = was.site("sole"), now.site(int(now.sensor("press").objid[0]))
    assert now.site(int(now.sensor(1).objid[0])).name == "sole"
    assert (new.type[0], now.body(int(new.bodyid[0])).name) == (old.type[0], "base")
    used = len(ZONES[shape].split())
    np.testing.assert_allclose(new.size[:used], old.size[:used], rtol=1e-12)
    np.testing.assert_allclose(new.pos, old.pos, atol=1e-12)
    np.testing.assert_allclose(np.abs(new.quat @ old.quat), 1.0, atol=1e-12)


def test_renamed_joints_and_links_keep_theirs(path):
    names = {"joints": {"b": "elbow"}, "links": {"link_f": "hand"}}
    model = compiled(rebuilt(path, names=names))
    servo = model.actuator("b")
    assert model.joint(int(servo.trnid[0])).name == "elbow"
    assert model.joint(int(model.sensor("angle").objid[0])).name == "elbow"
    assert model.body(int(model.sensor("place").objid[0])).name == "hand"


def test_actuators_are_taken_out_or_replaced_and_the_others_stay(path, tmp_path):
    for keys, names in (
        ({"*": "none"}, []),
        ({"c": "none"}, ["push", "b", "lag", "bent", "creep", "again"]),
        ({"a": {"type": "position", "kp": 44}}, ["spin", "b", "lag", "bent", "creep", "a"]),
    ):
        model = compiled(rebuilt(path, actuators=keys))
        assert names_of(model, "actuator", model.nu) == names
        sensors = set(names_of(model, "sensor", model.nsensor))
        assert {"angle", "imu"} <= sensors
        assert "*" not in keys or not {"effort", "spin_actuatorpos"} & sensors
    assert model.actuator("a").gainprm[0] == 44
    # A new one gets a name that no other has.
    other = '<actuator><motor name="a" joint="b"/></actuator>'
    model = compiled(rebuilt(written(tmp_path, text(other)), actuators={"a": "motor"}))
    assert names_of(model, "actuator", model.nu) == ["a", "a_2"]


def test_joints_are_held_at_home_as_far_as_actuators_can(path):
    """The forces of the compiled actuators against the weight: of two on one joint the first one holds it."""
    robot = robot_of(path)
    assert [actuator.dof for actuator in robot.actuators] == ["c", "a", "b", "d", "e", "f", "a"]
    outcome = rebuilt(path)
    assert outcome.written.actuation is not None
    homes = {actuator.name: actuator.home for actuator in outcome.written.actuation.actuators}
    assert homes["spin"] == homes["bent"] == homes["creep"] == homes["again"] == 0
    assert outcome.advice == ""
    model = compiled(outcome)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    weight, force = (
        {name: forces[model.joint(name).dofadr[0]] for name in "abcdef"}
        for forces in (data.qfrc_bias, data.qfrc_actuator)
    )
    assert [force[name] for name in "df"] == pytest.approx([weight[name] for name in "df"], rel=1e-9)
    # At the ends of their ranges: 10 times a control of -2, and a force of -3.
    assert (force["a"], force["b"]) == pytest.approx((max(weight["a"], -20), max(weight["b"], -3)), rel=1e-9)
    assert weight["b"] < -3


@pytest.mark.skipif(not hasattr(mujoco.mjtDyn, "mjDYN_PID"), reason="needs a MuJoCo with such actuators")
def test_an_actuator_that_is_lost_is_a_warning(tmp_path):
    lost = """<actuator><pid name="hold" joint="a" kp="3" ki="1"/><motor name="stay" joint="b" group="3"/>
      </actuator><sensor><actuatorfrc name="of_hold" actuator="hold"/></sensor>"""
    robot = robot_of(written(tmp_path, text(lost)))
    assert [actuator.name for actuator in robot.actuators] == ["stay"]
    assert robot.sensors == ()
    messages = {diagnostic.code: diagnostic.message for diagnostic in robot.diagnostics}
    assert "1 × actuator (hold)" in messages["W-MJCF-LEFT"]
    assert "1 × sensor (of_hold)" in messages["I-MJCF-LEFT"]
    assert "stay" not in "".join(messages.values())


def test_an_exported_file_read_again_gives_the_same_file(path, tmp_path):
    first = rebuilt(path).files["robot.xml"]
    (tmp_path / "again").mkdir()
    (tmp_path / "again" / "robot.xml").write_bytes(first)
    second = rebuilt(tmp_path / "again" / "robot.xml").files["robot.xml"]
    parts = [data[data.index(b"<actuator>") : data.index(b"<keyframe>")] for data in (first, second)]
    assert parts[0] == parts[1]
