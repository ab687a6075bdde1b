"""`elements` and `attributes`: XML of the user's own, in the files and in the compiled model."""

import difflib
import json

import mujoco
import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.amendments import Surplus
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate import validate
from tests.support import mjcfs
from tests.support.building import plan_of, write
from tests.support.exports import messages_of
from tests.support.robots import at, joint, loop, robot_with
from tests.support.states import pose_of, state
from tests.unit.export.test_scene import arm
from tests.unit.export.test_standing import geometry_of

pytestmark = pytest.mark.usefixtures("no_score")

BALL = "<body name='ball' pos='1 0 1'><freejoint name='rolls'/><geom size='0.1'/></body>"
SERVOS = {"*": "position"}


def add(xml, into, **more):
    return {"into": into, "xml": xml, **more}


def made(folder, robot=None, **keys):
    robot = robot or arm()
    return write(robot, folder, plan_of(**keys), geometry_of(robot))


def model(folder, name="scene.xml"):
    return mujoco.MjModel.from_xml_path(str(folder / name))


def at_elbow(folder, value):
    """The state of the scene at a value of the elbow."""
    return state(model(folder), elbow=value)


def failed(folder, outcome):
    return [check for check in validate(folder, outcome.written, plan_of()) if check.fails]


def lines_added(folder, **keys):
    """By file, the lines that these keys add (+) and take away (-)."""
    without, with_keys = made(folder / "without").files, made(folder / "with", **keys).files
    added = {}
    for name in ("robot.urdf", "robot.xml", "scene.xml"):
        lines = difflib.ndiff(*(files[name].decode().splitlines() for files in (without, with_keys)))
        added[name] = sorted(line[0] + line[1:].strip() for line in lines if line[0] in "+-")
    return {name: lines for name, lines in added.items() if lines}


@pytest.mark.parametrize(("keys", "expected"), [
    ({"elements": {"cam": add("<site name='s'/>", {"name": "arm"})}}, {"robot.xml": ['+<site name="s"/>']}),
    ({"elements": {"cam": add("<camera name='c' fovy='30'/><!-- c -->", {"name": "eye"})}},
     {"robot.xml": ['+<frame pos="0.1 0 0.05">', '+<camera name="c" fovy="30"/>', "+</frame>"]}),
    ({"elements": {"top": add("<gyro name='g' site='eye'/>", {"tag": "sensor"})}},
     {"robot.xml": ["+<sensor>", '+<gyro name="g" site="eye"/>', "+</sensor>"]}),
    ({"elements": {"root": add("<custom><numeric name='n' data='1'/></custom>", {"tag": "mujoco"})}},
     {"robot.xml": ["+<custom>", '+<numeric name="n" data="1"/>', "+</custom>"]}),
    ({"elements": {"lamp": add("<light name='l'/>", {"tag": "worldbody", "file": "scene"})}},
     {"scene.xml": ['+<light name="l"/>']}),
    ({"elements": {"gz": add("<gazebo reference='arm'/>", {"tag": "robot"})}},
     {"robot.urdf": ['+<gazebo reference="arm"/>']}),
    ({"elements": {"both": add("<plugin/>", {"name": "elbow"}, formats=["urdf"])}},
     {"robot.urdf": ["+<plugin/>"]}),
    ({"elements": {"size": add("<size nuser_jnt='2'/>", {"tag": "mujoco"})},
      "attributes": {"elbow": {"user": [1, 0.5], "group": 2, "limited": False, "axis": None}}},
     {"robot.xml": ['+<size nuser_jnt="2"/>', '-<joint name="elbow" class="hinge" axis="0 0 1"/>',
       '+<joint name="elbow" class="hinge" user="1 0.5" group="2" limited="false"/>']}),
    ({"attributes": {"elbow": {"formats": ["urdf"], "tag": "joint", "type": "revolute"}}},
     {"robot.urdf": ['-<joint name="elbow" type="continuous">', '+<joint name="elbow" type="revolute">']}),
])  # fmt: skip
def test_files_have_the_asked_changes_and_nothing_else(tmp_path, keys, expected):
    assert lines_added(tmp_path, **keys) == {name: sorted(lines) for name, lines in expected.items()}


def test_elements_go_in_by_name_of_any_kind_and_in_their_order(tmp_path):
    elements = {
        "one": add("<body name='tray' pos='0 0 0.2'><geom name='plate' size='0.1'/></body>", {"name": "arm"}),
        "two": add("<site name='on_tray' pos='0 0 0.1'/>", {"name": "tray"}),
        "three": add("<framepos name='where' objtype='site' objname='on_tray'/>", {"tag": "sensor"}),
        "four": add("<velocimeter name='fast' site='on_tray'/>", {"tag": "sensor"}),
        "lens": add("<site name='lens' pos='0 0 0.01'/>", {"name": "eye"}),
    }
    made(tmp_path, elements=elements, attributes={"on_tray": {"pos": [0, 0, 0.3]}})
    added = model(tmp_path)
    assert added.body(added.body("tray").parentid[0]).name == "arm"
    assert [added.sensor(number).name for number in range(added.nsensor)] == ["where", "fast"]
    for value in (0.0, 0.7):
        data = at_elbow(tmp_path, value)
        expected = pose_of(data.body("arm")) @ at(0, 0, 0.5)
        np.testing.assert_allclose(data.sensor("where").data, expected[:3, 3], atol=1e-12)
        lens = pose_of(data.site("eye")) @ at(0, 0, 0.01)
        np.testing.assert_allclose(pose_of(data.site("lens")), lens, atol=1e-12)


def test_element_on_a_merged_link_is_where_the_link_is(tmp_path):
    hand = joint("fixed", "arm", "hand", place=at(0.1, 0.2, 0.3), name="grip")
    robot = robot_with([joint("revolute", "base", "arm", name="elbow"), hand])
    camera = "<camera name='seen' pos='0 0 0.05'/><geom name='pad' size='0.01' pos='0 0 0.05'/>"
    exported = made(tmp_path, robot, elements={"on_hand": add(camera, {"name": "hand"})})
    assert exported.written.mjcf_form.fused == ("hand",)
    data = at_elbow(tmp_path, 0.6)
    hand = link_poses(robot, {"elbow": 0.6})["hand"]
    expected = (pose_of(data.body("base")) @ hand @ at(0, 0, 0.05))[:3, 3]
    np.testing.assert_allclose(data.camera("seen").xpos, expected, atol=1e-12)
    np.testing.assert_allclose(data.geom("pad").xpos, expected, atol=1e-12)


def test_tag_means_no_class(tmp_path):
    """The classes of a robot with a loop have <equality>, <joint> and <geom>, too."""
    loops = [loop("revolute", "arm", "base", at(0.1, 0, 0), at(0.1, 0, 0), name="ring")]
    robot = robot_with([joint("revolute", "base", "arm", name="elbow")], loops=loops)
    elements = {
        "weld": add("<weld name='own' body1='base' body2='arm' active='false'/>", {"tag": "equality"}),
        "body": add("<site name='first'/>", {"tag": "body"}),
        "class": add("<default class='own'><joint damping='1'/></default>", {"tag": "default"}),
    }
    exported = made(tmp_path, robot, elements=elements)
    root = parse(exported.files["robot.xml"])
    for path in (
        "default//equality", "equality/weld[@name='own']", "default/default[@class='own']",
        "worldbody/body[@name='base']/site[@name='first']",
    ):  # fmt: skip
        assert root.find(path) is not None, path
    assert exported.written.amendments.surplus_of("robot.xml").equalities == 1
    assert failed(tmp_path, exported) == []


def test_names_are_looked_for_in_the_robot_then_in_the_scene(tmp_path):
    friction = {"friction": "1 0.5 0.5"}
    made(tmp_path, attributes={"floor": friction, "arm_collision": friction})
    added = model(tmp_path)
    for name in ("floor", "arm_collision"):
        assert added.geom(name).friction.tolist() == [1, 0.5, 0.5]
    assert added.geom("base_collision").friction.tolist() != [1, 0.5, 0.5]


def test_keyframes_and_checks_know_what_was_added(tmp_path):
    """A ball that is free to roll, and a motor, before and after all that is the robot's own."""
    robot = arm(fixed=False)
    elements = {
        "first": add("<body name='hung' pos='0 0 0.3'><joint name='swings' ref='0.2'/>"
                     "<geom size='0.01' contype='0' conaffinity='0'/></body>", {"name": "base"}),
        "ball": add(BALL, {"tag": "worldbody"}),
        "motor": add("<motor name='extra' joint='swings' gear='2'/>", {"tag": "actuator"}),
        "weld": add("<joint name='held' joint1='swings'/>", {"tag": "equality"}),
    }  # fmt: skip
    exported = made(tmp_path, robot, elements=elements, actuators=SERVOS)
    made(tmp_path / "plain", robot, actuators=SERVOS)
    assert failed(tmp_path, exported) == []
    assert exported.written.amendments.surplus_of("scene.xml") == Surplus("scene.xml", 7, 1, 1)
    added, before = model(tmp_path), model(tmp_path / "plain")
    assert (added.nu, added.nkey) == (2, before.nkey)
    for name in ("home", "cad"):
        key, old = added.key(name), before.key(name)
        for joint_name, width in (("elbow", 1), ("base_free", 7)):
            here, there = added.joint(joint_name).qposadr[0], before.joint(joint_name).qposadr[0]
            assert key.qpos[here : here + width].tolist() == old.qpos[there : there + width].tolist()
        assert key.qpos[added.joint("swings").qposadr[0]] == 0.2
        first = added.joint("rolls").qposadr[0]
        assert key.qpos[first : first + 7].tolist() == [1, 0, 1, 1, 0, 0, 0]
        assert key.ctrl[added.actuator("elbow").id] == old.ctrl[0]
        assert key.ctrl[added.actuator("extra").id] == 0


@pytest.mark.parametrize("into", [{"name": "base"}, {"tag": "worldbody", "file": "scene"}])
def test_keyframes_of_a_scene_with_moving_bodies_are_completed(tmp_path, into):
    """A source with a ball beside the robot: its keyframes are in the scene."""
    hinge = '<joint name="hinge" axis="0 1 0"/><geom size="0.05"/>'
    loose = '<body name="loose" pos="1 0 1"><freejoint name="rolls"/><geom size="0.1"/></body>'
    key = '<keyframe><key name="home" qpos="0.1 1 0 1 1 0 0 0"/></keyframe>'
    source = mjcfs.written(tmp_path, mjcfs.model(mjcfs.body("base", hinge, pos="0 0 1") + loose, key))
    hung = "<body name='hung'><joint name='swings' ref='0.2'/><geom size='0.01' mass='0.1'/></body>"
    _, failures = mjcfs.built(source, tmp_path, elements={"hung": add(hung, into)})
    assert failures == ()
    added = model(tmp_path)
    qpos = added.key("home").qpos
    values = {name: qpos[added.joint(name).qposadr[0]] for name in ("hinge", "swings")}
    assert values == {"hinge": 0.1, "swings": 0.2}
    first = added.joint("rolls").qposadr[0]
    assert qpos[first : first + 7].tolist() == [1, 0, 1, 1, 0, 0, 0]


@pytest.mark.skipif(not hasattr(mujoco.MjModel, "nactuator"), reason="an actuator has a single control")
def test_added_actuator_may_have_several_controls(tmp_path):
    pid = {"pid": add("<pid name='extra' joint='elbow' kp='1' forcerange='-5 5'/>", {"tag": "actuator"})}
    exported = made(tmp_path, elements=pid, actuators=SERVOS)
    assert failed(tmp_path, exported) == []
    assert exported.written.amendments.surplus_of("robot.xml") == Surplus("robot.xml", 0, 1, 0)
    added = model(tmp_path)
    assert (added.nu, added.key("home").ctrl.tolist()[1:]) == (3, [0, 0])


def test_check_that_fails_names_the_key_that_did_it(tmp_path):
    outcome = made(tmp_path, attributes={"elbow": {"damping": 3}, "floor": {"friction": [1, 0.5, 0.5]}})
    (check,) = failed(tmp_path, outcome)
    assert check.name == "robot.xml: joints"
    assert check.detail == "differ: elbow; the file was changed by attributes.elbow"


def test_weight_that_is_added_is_no_fault_but_a_moved_body_is(tmp_path):
    heavy = add("<inertial pos='0 0 0' mass='9' diaginertia='1 1 1'/>", {"name": "tray"})
    tray = add("<body name='tray'><geom size='0.1' contype='0' conaffinity='0'/></body>", {"name": "arm"})
    assert failed(tmp_path, made(tmp_path, elements={"tray": tray, "heavy": heavy})) == []
    checks = failed(tmp_path / "arm", made(tmp_path / "arm", attributes={"arm": {"pos": [0, 0, 0.1]}}))
    assert checks
    assert all("attributes.arm" in check.detail for check in checks)


MIXED = {
    "elements": {"ball": add(BALL, {"tag": "worldbody"}), "gz": add("<gazebo/>", {"tag": "robot"})},
    "attributes": {"floor": {"rgba": "1 0 0 1"}},
}


def test_robot_json_says_what_was_changed(tmp_path):
    table = json.loads(made(tmp_path, **MIXED).files["robot.json"])
    assert [tuple(amendment.values()) for amendment in table["amendments"]] == [
        ("elements.gz", "robot.urdf", "robot robot", ["<gazebo>"], []),
        ("elements.ball", "robot.xml", "<worldbody>", ["body ball"], []),
        ("attributes.floor", "scene.xml", "geom floor", [], ["rgba"]),
    ]
    assert list(table["amendments"][0]) == ["key", "file", "target", "adds", "sets"]
    assert "amendments" not in json.loads(made(tmp_path / "plain").files["robot.json"])


def test_entries_of_a_format_that_is_not_written_are_named(tmp_path):
    outcome = made(tmp_path, **MIXED, export={"urdf": {}})
    (remark,) = messages_of(outcome, "I-ELEMENT")
    named = [key in remark for key in ("elements.ball", "attributes.floor", "elements.gz")]
    assert named == [True, True, False]
    assert b"<gazebo/>" in outcome.files["robot.urdf"]


def test_text_of_a_file_replaces_the_file():
    robot = arm()
    plan = plan_of(elements={"cam": {"into": {"name": "arm"}, "file": "mount.xml"}})
    exported = export(robot, geometry_of(robot), plan, {"cam": "<site name='s'/>"})
    root = parse(exported.files["robot.xml"])
    assert root.find(".//body[@name='arm']/site[@name='s']") is not None


REFUSED = [
    ({"a": add("<site/>", {"name": "arn"})}, {}, "elements.a.into", "did you mean arm?"),
    ({"a": add("<site/>", {"name": "zzz"})}, {}, "elements.a.into", "there are: arm, "),
    ({"a": add("<site/>", {"tag": "bdy"})}, {}, "elements.a.into", "did you mean body?"),
    ({"a": add("<light/>", {"name": "arm", "file": "scene"})}, {}, "elements.a.into", "in scene.xml"),
    ({"a": add("<gazebo/>", {"tag": "worldbody"})}, {}, "elements.a.into", "robot.urdf has no element"),
    ({"a": add("<site name='eye'/>", {"name": "arm"})}, {}, "elements.a", "so is a site in robot.xml"),
    ({"a": add("<geom name='floor' size='1'/>", {"name": "arm"})}, {}, "elements.a", "in scene.xml"),
    ({"a": add("<site name='s'/><site name='s'/>", {"name": "arm"})}, {}, "elements.a", "'s'"),
    ({"a": add("<sitee/>", {"name": "arm"})}, {}, "elements.a", "nor URDF has an element <sitee>"),
    ({"a": add("<site nme='s'/>", {"name": "arm"})}, {}, "elements.a", "did you mean name?"),
    ({"a": add("<geom size='0'/>", {"name": "arm"}), "b": add("<site/>", {"name": "arm"})}, {}, "elements.a",
     "size 0 must be positive"),
    ({"a": add("<link name='arm'/>", {"tag": "robot"})}, {}, "elements.a", "so is a link in robot.urdf"),
    ({"a": add(BALL, {"tag": "worldbody", "file": "scene"})}, {}, "elements.a", "leave out `file: scene`"),
    ({"a": add("<replicate count='2'><body><joint/><geom size='1'/></body></replicate>", {"name": "arm"})},
     {}, "elements", "write these bodies out"),
    ({}, {"flor": {"rgba": "1 0 0 1"}}, "attributes.flor", "did you mean floor?"),
    ({}, {"elbow": {"damping": 1}}, "attributes.elbow", "say which: tag: actuator or joint or position"),
    ({}, {"arm": {"tag": "joint", "damping": 1}}, "attributes.arm", "no element <joint> is named 'arm'"),
    ({}, {"arm": {"mass": None}}, "attributes.arm.mass", "its own attributes are: name"),
    ({}, {"arm": {"gravcmp": 1}}, "attributes.arm", "did you mean gravcomp?"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("elements", "attributes", "where", "said"), REFUSED, ids=lambda value: str(value)[:40]
)
def test_impossible_change_is_named_with_what_there_is(tmp_path, elements, attributes, where, said):
    with pytest.raises(ExportError) as caught:
        made(tmp_path, elements=elements, attributes=attributes, actuators=SERVOS)
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("E-ELEMENT", where)
    assert said in f"{problem.message} {problem.hint}"


def test_all_problems_are_told_at_once(tmp_path):
    elements = {"a": add("<site/>", {"name": "arn"}), "b": add("<gazebo/>", {"tag": "lnk"})}
    with pytest.raises(ExportError) as caught:
        made(tmp_path, elements=elements, attributes={"flor": {"rgba": "1 0 0 1"}})
    places = {problem.where for problem in caught.value.problems}
    assert places == {"elements.a.into", "elements.b.into", "attributes.flor"}


def test_link_that_is_added_to_a_urdf_counts(tmp_path):
    xml = """<link name='fin'/><joint name='flap' type='revolute'><parent link='arm'/><child link='fin'/>
    <axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"""
    robot = robot_with([joint("revolute", "base", "arm", name="elbow")])
    exported = made(tmp_path, robot, elements={"fin": add(xml, {"tag": "robot"})})
    assert exported.written.amendments.surplus_of("robot.urdf").dofs == 1
    assert [check.name for check in failed(tmp_path, exported) if "links and joints" in check.name] == []
