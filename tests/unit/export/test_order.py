"""The order of joints, actuators and sensors is that of MuJoCo's arrays and of Pinocchio's tree."""

import json

import mujoco
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from linkwright.stages.export.configuration.sensor_section import MEASURES
from linkwright.stages.export.order.of_mjcf import MjcfOrder
from linkwright.stages.export.order.of_urdf import urdf_rows
from linkwright.stages.fetch.mjcf.compiled.actuation import _PLAIN_SENSORS
from linkwright.stages.formats.mjcf.joints import joints_in_order
from linkwright.stages.formats.robot_json.codec import write
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.model.actuation import NONE, Actuation, Actuator
from linkwright.stages.robot.model.sensor_kinds import DIMENSIONS, unit_of
from tests.fake_onshape.random_document import documents
from tests.support.building import plan_of, robot_of, sample_robot
from tests.support.exports import compiled, exported
from tests.support.pinocchio import pin
from tests.support.robots import CARRIED, EVERY, at, joint, loop, pose, robot_with

ALONE = robot_with()
KINDS = {"free": 0, "ball": 1, "slide": 2, "turn": 3}


def measured(robot, **keys):
    """The export of a robot with a sensor of each kind."""
    place = {"type": "frame", "frame": robot.root.name, "measure": ["quat", "pos"]}
    imu = {**place, "type": "imu", "measure": ["gyro", "quat"]}
    sensors = {"joints": "joint", "drives": "actuator", "place": place, "imu": imu}
    actuators = {"*": {"type": "position", "encoder": True, "force": True}}
    return exported(robot, sensors=sensors, actuators=actuators, **keys)


def agrees(outcome):
    """The tables of robot.json, compared with the compiled model and with Pinocchio's."""
    order = json.loads(outcome.files["robot.json"])["order"]
    model = compiled(outcome)
    as_mujoco(order["mjcf"], model)
    urdf = pin.buildModelFromXML(outcome.files["robot.urdf"].decode())
    rows = order["urdf"]["joints"]
    assert [row["name"] for row in sorted(rows, key=lambda row: row["tree"])] == list(urdf.names)[1:]
    nodes = [node for node in parse(outcome.files["robot.urdf"]).iter("joint") if node.get("type")]
    moving = [node.get("name") for node in nodes if node.get("type") != "fixed"]
    assert [row["name"] for row in rows] == moving
    assert [row["index"] for row in rows] == list(range(len(rows)))
    there = {row["name"]: row["urdf"] for row in order["mjcf"]["joints"]}
    for row in rows:
        assert row["name"] in there[row["dof"]]
    return order


def as_mujoco(order, model):
    joints, actuators, sensors = order["joints"], order["actuators"], order["sensors"]
    names = [model.joint(index).name for index in range(model.njnt)]
    assert [row["name"] for row in joints] == names
    assert [KINDS[row["kind"]] for row in joints] == list(model.jnt_type)
    for key, addresses, size in (("qpos", model.jnt_qposadr, model.nq), ("dof", model.jnt_dofadr, model.nv)):
        assert [row[key][0] for row in joints] == list(addresses)
        assert sum(row[key][1] for row in joints) == size
    assert [row["ctrl"][0] for row in actuators] == [int(model.actuator(row["name"]).id) for row in actuators]
    for row in actuators:
        actuator = model.actuator(row["name"])
        assert model.joint(actuator.trnid[0]).name == row["joint"]
        limited = bool(model.actuator_ctrllimited[actuator.id])
        assert limited == (row["range"] is not None)
        if limited:
            np.testing.assert_allclose(row["range"], actuator.ctrlrange, atol=1e-12)
    names = [model.sensor(index).name for index in range(model.nsensor)]
    rows = list(zip(names, model.sensor_adr, model.sensor_dim, strict=True))
    assert [(row["name"], row["address"], row["dim"]) for row in sensors] == rows


def test_order_of_the_sample_has_names_of_mates_and_units():
    robot = sample_robot()
    outcome = measured(robot)
    order = agrees(outcome)
    mates = {dof.name: joint.mate.name for joint in robot.joints if joint.mate for dof in joint.dofs}
    units = {"turn": ("rad", "rad/s"), "slide": ("m", "m/s")}
    rows = {row["name"]: row for row in order["mjcf"]["joints"]}
    assert {name: row["cad"] for name, row in rows.items()} == mates
    assert {row["name"]: row["cad"] for row in order["urdf"]["joints"]} == mates
    for dof in robot.dofs:
        value, speed = units[dof.kind]
        assert rows[dof.name]["unit"] == value
        sensors = {row["name"]: row["unit"] for row in order["mjcf"]["sensors"] if row["on"] == dof.name}
        assert (sensors[f"joints_{dof.name}_pos"], sensors[f"joints_{dof.name}_vel"]) == (value, speed)
    assert len(order["mjcf"]["actuators"]) > 1
    for row in order["mjcf"]["actuators"]:
        assert (row["unit"], row["cad"]) == (rows[row["joint"]]["unit"], mates[row["joint"]])
    followers = {row["name"]: row["follows"] for row in order["urdf"]["joints"] if row["follows"]}
    assert followers == {
        relation.follower: relation.driver
        for relation in (*robot.relations, *outcome.written.urdf_form.mimics)
    }
    assert len(followers) > len(robot.relations) > 0


def mixed(fixed):
    """Joints of every type, listed so that a link's children are not beside each other, and fixed ones."""
    rng = np.random.default_rng(3)
    kinds = [kind for kind in EVERY if kind != "free"]
    links = [f"{name}{number}" for number, name in enumerate("mzkbxacd")]
    parents = ["base", "base", links[0], links[1], links[0], "base", links[3], links[1]]
    joints = [
        joint(kind, parent, link, place=pose(rng))
        for kind, parent, link in zip(kinds, parents, links, strict=True)
    ]
    loops = [
        loop(kind, links[-1], links[number], at(0.1, 0, 0), pose(rng), name=f"loop_{kind}")
        for number, kind in enumerate(CARRIED)
    ]
    loose = [joint("free", "base", "loose", place=pose(rng))]
    return robot_with([*joints[:4], *loose, *joints[4:]] if fixed else joints, loops=loops, fixed=fixed)


@pytest.mark.slow
@pytest.mark.parametrize("fixed", [True, False])
@pytest.mark.parametrize("form", ["merge", "keep"])
def test_order_of_joints_of_every_type_loops_and_fixed_links(fixed, form):
    robot = mixed(fixed)
    keys = {"mjcf": {"fixed_joints": form}, "urdf": {"fixed_joints": form}}
    order = agrees(measured(robot, export=keys))
    rows = {row["name"]: row for row in order["mjcf"]["joints"]}
    carried = [dof.name for loop in robot.loops for dof in loop.dofs]
    assert all(rows[name]["urdf"] == [] for name in carried)
    assert rows[carried[0]]["cad"] == robot.loops[0].mate.name
    assert len(next(row["urdf"] for row in rows.values() if row["kind"] == "ball")) == 3
    if not fixed:
        assert order["mjcf"]["joints"][0]["kind"] == "free"
        assert order["mjcf"]["joints"][0]["cad"] is None


@pytest.mark.slow
@settings(max_examples=30, suppress_health_check=[*HealthCheck])
@given(documents(loops=True, everything=True), st.sampled_from(["auto", "free"]))
def test_order_of_random_documents(document, base):
    robot = robot_of(document)
    base = "auto" if robot.root.name == "world" else base
    agrees(measured(robot_of(document, plan_of(root={"base": base}))))


def test_order_is_of_the_written_formats_only():
    robot = robot_with([joint("revolute", "base", "arm")])
    for name, other in (("mjcf", "urdf"), ("urdf", "mjcf")):
        outcome = exported(robot, export={name: {}, other: None})
        assert list(json.loads(outcome.files["robot.json"])["order"]) == [name]
    assert outcome.details["order"] == write(outcome.order)


def tables_of(text, robot=ALONE, actuation=NONE):
    """The tables of an MJCF's text."""
    return write(MjcfOrder(parse(text), robot, actuation, {}, {}).record())


OTHERS = """<mujoco><default><default class="a"><joint type="slide"/><default class="b"><geom size="1"/>
  </default></default></default>
  <worldbody><body name="one" childclass="b"><geom/><frame childclass="main">
    <body name="two"><joint name="y"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>
    </frame><frame><joint name="x"/></frame><joint name="w" class="main"/></body></worldbody>
  <worldbody><body name="three"><freejoint name="v"/><geom size="1"/></body>
    <body name="four"><joint type="ball" name="u"/><geom size="1"/></body></worldbody>
  <tendon><fixed name="t"><joint joint="x" coef="1"/></fixed></tendon>
  <actuator><motor name="pull" tendon="t" ctrlrange="-2 3"/></actuator>
  <sensor><tendonpos name="reach" tendon="t"/><user name="mine" dim="5"/><gyro name="g" site="s"/></sensor>
  <worldbody><site name="s"/></worldbody>
</mujoco>"""


def test_order_of_things_that_users_add_by_hand():
    """Frames, classes, more sections, and things that the robot does not know."""
    tables, model = tables_of(OTHERS.encode()), mujoco.MjModel.from_xml_string(OTHERS)
    as_mujoco(tables | {"actuators": []}, model)
    (row,) = tables["actuators"]
    assert (row["name"], row["ctrl"], row["range"], row["unit"]) == ("pull", [0, 1], [-2, 3], None)


SERVOS = """<mujoco><worldbody><body><joint name='j'/><geom size='1'/></body></worldbody><actuator>
  <pid name="a" joint="j" kp="1"/><motor name="b" joint="j"/><pid name="c" joint="j" input="pos"/>
  <pid name="d" joint="j" kp="1" input="pos vel ff"/><motor name="e" joint="j"/></actuator></mujoco>"""


def test_order_of_actuators_with_several_controls():
    """MuJoCo 3.12 has them: a pid with a position, a speed and a force."""
    rows = tables_of(SERVOS.encode())["actuators"]
    assert [row["ctrl"] for row in rows] == [[0, 2], [2, 1], [3, 1], [4, 3], [7, 1]]
    if not hasattr(mujoco.MjModel, "nactuator"):
        pytest.skip("this MuJoCo's actuators have one control each")
    model = mujoco.MjModel.from_xml_string(SERVOS)
    assert [row["ctrl"][0] for row in rows] == list(model.actuator_ctrladr)
    assert [row["ctrl"][1] for row in rows] == list(model.actuator_ctrlnum)


UNITS = {
    "motor": ("N m", "N"), "position": ("rad", "m"), "velocity": ("rad/s", "m/s"),
    "intvelocity": ("rad/s", "m/s"), "damper": ("-", "-"), "pid": ("rad", "m"), "dcmotor": ("V", "V"),
}  # fmt: skip


@pytest.mark.parametrize("kind", UNITS)
def test_unit_of_a_control_is_that_of_its_actuator(kind):
    robot = robot_with([joint("revolute", "base", "arm"), joint("prismatic", "arm", "hand")])
    made = Actuation(tuple(Actuator(f"{joint.child}_drive", joint.name, kind) for joint in robot.joints))
    nodes = "".join(f'<{kind} name="{joint.child}_drive" joint="{joint.name}"/>' for joint in robot.joints)
    rows = tables_of(f"<mujoco><actuator>{nodes}</actuator></mujoco>".encode(), robot, made)["actuators"]
    assert tuple(row["unit"] for row in rows) == UNITS[kind]


def test_sensors_after_one_of_unknown_size_have_no_address():
    text = b"<mujoco><sensor><clock name='a'/><plugin name='b'/><clock name='c'/></sensor></mujoco>"
    rows = tables_of(text)["sensors"]
    assert [(row["address"], row["dim"]) for row in rows] == [(0, 1), (1, None), (None, 1)]


def test_model_that_does_not_compile_is_left_to_the_checks():
    joints = '<body><joint name="a" type="bent"/><joint name="b"/></body>'
    more = '<actuator><motor ctrlrange="a b"/></actuator><sensor><user name="u" dim="x"/></sensor>'
    text = f"<mujoco><worldbody>{joints}</worldbody>{more}</mujoco>".encode()
    tables = tables_of(text)
    assert [row["name"] for row in tables["joints"]] == ["a", "b"]
    assert tables["actuators"][0]["range"] is None
    assert tables["sensors"][0]["dim"] is None
    urdf = b"<robot><link name='l'/><joint name='j' type='revolute'/></robot>"
    assert [row.tree for row in urdf_rows(parse(urdf), {}, {})] == [None]


def test_urdf_joint_without_a_name_has_a_row():
    joints = "".join(
        f"<joint {name} type='revolute'><parent link='a'/><child link='{child}'/></joint>"
        for name, child in (("", "b"), ("name='turn'", "c"))
    )
    links = "".join(f"<link name='{link}'/>" for link in "abc")
    rows = list(urdf_rows(parse(f"<robot name='r'>{links}{joints}</robot>".encode()), {}, {}))
    assert [(row.name, row.tree) for row in rows] == [(None, None), ("turn", 1)]


def test_deep_tree_is_walked():
    text = "<body><joint/>" * 1500 + "</body>" * 1500
    root = parse(f"<mujoco><worldbody>{text}</worldbody></mujoco>".encode(), large=True)
    assert len(list(joints_in_order(root))) == 1500
    text = "<frame>" * 1500 + "<joint/>" + "</frame>" * 1500
    root = parse(f"<mujoco><worldbody><body>{text}</body></worldbody></mujoco>".encode(), large=True)
    assert len(list(joints_in_order(root))) == 1


def test_sensors_have_a_size_and_a_unit():
    made = {kind for measures in MEASURES.values() for kind in measures.values()}
    for kind in made | set(_PLAIN_SENSORS):
        assert kind in DIMENSIONS
        assert unit_of(kind, "turn"), kind
        assert unit_of(kind, "slide"), kind
    assert (unit_of("actuatorfrc", "slide"), unit_of("jointlimitvel", "turn")) == ("N", "rad/s")
