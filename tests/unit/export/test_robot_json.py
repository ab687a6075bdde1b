"""robot.json: enough to rebuild the robot's kinematics, without its code."""

import json
from dataclasses import replace

import numpy as np
import pytest
from lxml import etree
from scipy.spatial.transform import Rotation

from linkwright.stages.export.robot_json import describe
from linkwright.stages.export.urdf.lowering import lower
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.codec import decode_robot, encode_robot
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Frame, Primitive, frozen
from linkwright.stages.robot.motion import kinematics
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.support.building import plan_of, robot_of, write
from tests.support.engines import Mujoco, Pinocchio
from tests.support.exports import exported, messages_of
from tests.support.robots import (
    EVERY,
    LOOPS,
    at,
    joint,
    loop,
    pose,
    robot_with,
    solid,
    some_value,
    some_values,
)


def described(robot):
    return json.loads(describe(Written(robot)))


def matrix(record):
    if record is None:
        return np.eye(4)
    return from_parts(Rotation.from_quat(np.roll(record["quat"], -1)).as_matrix(), np.array(record["xyz"]))


def moved(dof, value):
    """A dof's motion, from its record alone."""
    if dof["kind"] in ("ball", "free"):
        return matrix({"xyz": value[:3] if dof["kind"] == "free" else [0, 0, 0], "quat": value[-4:]})
    along = np.array(dof["axis"]) * value
    if dof["kind"] == "slide":
        return at(*along)
    return from_parts(Rotation.from_rotvec(along).as_matrix(), np.zeros(3))


def chain(dofs, q):
    out = np.eye(4)
    for dof in dofs:
        out = out @ matrix(dof["origin"]) @ moved(dof, q[dof["name"]])
    return out


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kind", EVERY)
def test_file_alone_gives_the_poses_of_all_links(kind, backwards):
    rng = np.random.default_rng(EVERY.index(kind))
    origins = [pose(rng) for _ in range(3)]
    first = joint(kind, "base", "one", place=pose(rng), backwards=backwards, origins=origins)
    robot = robot_with([first, joint("revolute", "one", "two", place=pose(rng))])
    table = described(robot)
    q = some_values(robot, rng)
    expected, actual = link_poses(robot, q), {"base": np.eye(4)}
    for record in table["joints"]:
        actual[record["child"]] = (
            actual[record["parent"]] @ matrix(record["origin"]) @ chain(record["dofs"], q)
        )
    assert max(np.abs(actual[name] - expected[name]).max() for name in expected) < 1e-11
    record = table["joints"][0]
    assert (record["type"], record["backwards"]) == (kind, backwards)
    assert record["cad"] == {"owner": [], "feature": "one_joint", "name": "one_joint", "type": kind.upper()}


@pytest.mark.parametrize("backwards", [False, True])
def test_ball_has_the_value_of_its_chain_and_of_its_mate(backwards):
    value = some_value("ball", np.random.default_rng(2))
    slide = joint("cylindrical", "base", "rod", (0.1, 0.2))
    table = described(robot_with([joint("ball", "base", "arm", (value,), backwards=backwards), slide]))
    (dof,) = table["joints"][0]["dofs"]
    assert dof["mate_quat"] == pytest.approx(value, abs=1e-11)
    back = (value[0], *(-x for x in value[1:])) if backwards else value
    assert dof["saved"] == pytest.approx(back, abs=1e-11)
    # qpos0 is the start, and not the saved pose.
    assert dof["qpos0"] == [1, 0, 0, 0]
    assert [(dof["saved"], dof["qpos0"]) for dof in table["joints"][1]["dofs"]] == [(0.1, 0), (0.2, 0)]


def test_zero_of_a_ball_is_reported_by_format(tmp_path):
    """Its loop is closed in the saved pose alone, so the MJCF starts there."""
    value = (0.8, 0.0, 0.6, 0.0)
    joints = [joint("ball", "base", "arm", [value])]
    poses = link_poses(robot_with(joints), {"arm_joint": value})
    ends = np.linalg.inv(poses["arm"]), np.linalg.inv(poses["base"])
    robot = robot_with(joints, loops=[loop("revolute", "arm", "base", *ends, [0.0])])
    outcome = write(robot, tmp_path)
    (dof,) = described(robot)["joints"][0]["dofs"]
    assert dof["zero"] == {"urdf": [1, 0, 0, 0], "mjcf": list(value)}
    engines = {"urdf": Pinocchio(outcome.files["robot.urdf"]), "mjcf": Mujoco(tmp_path / "robot.xml")}
    for kind, engine in engines.items():
        actual = engine.poses({"arm_joint": (1.0, 0.0, 0.0, 0.0)})["arm"]
        wanted = link_poses(robot, {"arm_joint": tuple(dof["zero"][kind])})["arm"]
        np.testing.assert_allclose(actual, wanted, atol=1e-12)
    (zero,) = messages_of(outcome, "I-BALL-ZERO")
    assert "arm_joint (73.74 deg apart)" in zero


def test_frames_of_a_loop_are_named_as_the_urdf_has_them():
    """Even where a link and a frame have the names that they would have."""
    joints = [joint("revolute", "base", name, [0.1]) for name in ("arm", "shut_a")]
    shut = loop("revolute", "arm", "shut_a", at(1, 0, 0), at(0, 1, 0), [0.0], name="shut")
    frames = Frame("shut_b", "base", at(0, 0, 1), ""), Frame("arm", "base", at(0, 0, 2), "")
    robot = robot_with(joints, loops=[shut], frames=frames)
    urdf = etree.fromstring(exported(robot).files["robot.urdf"])
    holders = {element.find("child").get("link"): element for element in urdf.findall("joint")}
    table = described(robot)
    assert table["loops"][0]["urdf"] == ["shut_a_2", "shut_b_2"]
    names = {frame["name"]: frame["urdf"] for frame in table["frames"]}
    assert names == {"shut_b": "shut_b", "arm": "arm_frame"}
    for name, link, place in (
        ("shut_a_2", "arm", "1 0 0"), ("shut_b_2", "shut_a", "0 1 0"), ("arm_frame", "base", "0 0 2"),
    ):  # fmt: skip
        assert holders[name].find("parent").get("link") == link
        assert holders[name].find("origin").get("xyz") == place


def test_joints_of_the_urdf_in_place_of_a_ball_are_listed():
    robot = robot_with([joint("revolute", "base", "arm"), joint("ball", "arm", "hand")])
    turns, links = [f"hand_joint_{axis}" for axis in "xyz"], ["hand_joint_1", "hand_joint_2"]
    assert described(robot)["lowered"] == [{"joint": "hand_joint", "joints": turns, "links": links}]
    assert [item.added_links for item in lower(robot)] == [(), tuple(links)]


def test_things_that_cad_does_not_have_are_marked():
    box = Primitive("box", (0.1, 0.2, 0.3), at(1, 0, 0), (1.0, 0.5, 0.0, 1.0), collision=False)
    ball = Primitive("sphere", (0.1,), at(0, 2, 0))
    rows = [replace(joint("fixed", "base", "tool"), mate=None), joint("revolute", "base", "arm")]
    spots = [Frame("tip", "arm", at(0, 0, 1), ""), Frame("eye", "arm", at(0, 1, 0), "The eye")]
    robot = robot_with(rows, frames=spots, given={"tool": solid(3.0)}, shapes={"tool": (box, ball)})
    tool = replace(robot.link("tool"), path=(), parts=())
    table = described(replace(robot, links=(robot.links[0], tool, robot.links[2])))
    assert [record["cad"] is None for record in table["joints"]] == [True, False]
    assert [record["cad"] for record in table["frames"]] == [None, {"name": "The eye"}]
    base, tool, arm = table["links"]
    assert (tool["given"], tool["cad"], tool["mass"], tool["parts"]) == (True, None, 3, [])
    assert (arm["given"], arm["cad"], arm["shapes"]) == (False, {"path": ["arm"]}, [])
    assert tool["shapes"] == [
        {
            "kind": "box", "size": [0.1, 0.2, 0.3], "pose": {"xyz": [1, 0, 0], "quat": [1, 0, 0, 0]},
            "colour": [1, 0.5, 0, 1], "visual": True, "collision": False,
        },
        {
            "kind": "sphere", "size": [0.1], "pose": {"xyz": [0, 2, 0], "quat": [1, 0, 0, 0]}, "colour": None,
            "visual": True, "collision": True,
        },
    ]  # fmt: skip
    assert table["total_mass"] == pytest.approx(sum(link["mass"] for link in (base, tool, arm)))


def test_mirrored_part_has_the_pose_of_its_image():
    robot = robot_with([joint("revolute", "base", "arm")])
    where = pose(np.random.default_rng(4)) @ np.diag([-1.0, 1.0, 1.0, 1.0])
    arm = robot.link("arm")
    flipped = replace(arm, parts=(replace(arm.parts[0], link_from_part=frozen(where)),))
    base, arm = described(replace(robot, links=(robot.root, flipped)))["links"]
    assert not base["parts"][0]["mirrored"]
    assert matrix(base["parts"][0]["pose"]) == pytest.approx(robot.root.parts[0].link_from_part, abs=1e-11)
    (part,) = arm["parts"]
    assert part["mirrored"]
    assert matrix(part["pose"]) @ np.diag([1.0, 1.0, -1.0, 1.0]) == pytest.approx(where, abs=1e-11)


@pytest.mark.parametrize("kind", LOOPS)
def test_loop_closes_by_its_record(kind):
    rng = np.random.default_rng(LOOPS.index(kind))
    near, far = pose(rng), pose(rng)
    values = [some_value(dof.kind, rng) for dof in loop(kind, "one", "two", near, far).dofs]
    shut = loop(kind, "one", "two", near, far, values)
    rows = [joint("fixed", "base", "one"), joint("fixed", "base", "two")]
    (record,) = described(robot_with(rows, loops=[shut]))["loops"]
    assert (record["type"], record["link_a"], record["link_b"]) == (kind, "one", "two")
    saved = {dof["name"]: dof["saved"] for dof in record["dofs"]}
    by_record = matrix(record["frame_b"]) @ chain(record["dofs"], saved)
    by_model = far @ kinematics.chain(shut.dofs, {dof.name: dof.saved for dof in shut.dofs})
    assert by_record == pytest.approx(by_model, abs=1e-11)
    assert matrix(record["frame_a"]) == pytest.approx(near, abs=1e-11)


QUANTITIES = ("lower", "upper", "effort", "velocity", "damping", "friction", "armature")
UNSET = ("unset",) * 5
JOINTS = {"*": {"effort": 5, "damping": 0.1}, "elbow": {"limits": [None, 0.8]}}


@pytest.mark.parametrize(("limits", "keys", "origins"), [
    ((0, 1), {}, ("source", "source", *UNSET)),
    ((None, 1), {}, ("unset", "source", *UNSET)),
    ((0, 1), {"joints": JOINTS}, ("unset", "given", "given", "unset", "given", "unset", "unset")),
    ((0, 1), {"actuators": {"*": {"type": "position"}}}, ("source", "source", *UNSET[1:], "estimated")),
], ids=["limits of the mate", "one limit", "given by joints", "an estimated armature"])  # fmt: skip
def test_each_quantity_of_a_joint_has_its_origin(kit, limits, keys, origins):
    kit.elbow(value=0.3, limits=limits)
    robot = decode_robot(encode_robot(robot_of(kit.document, plan_of(**keys))))
    dof = only_dof(exported(robot, **keys))
    assert dof["provenance"] == dict(zip(QUANTITIES, origins, strict=True))
    assert dof["unset"] == [name for name in QUANTITIES[:4] if dof["provenance"][name] == "unset"]


def only_dof(outcome):
    ((dof,),) = [joint["dofs"] for joint in json.loads(outcome.files["robot.json"])["joints"]]
    return dof


def test_joint_of_an_added_link_has_given_limits(kit):
    kit.place("Base", fixed=True)
    lid = {"parent": "base", "mass": 0.1, "geometry": {"sphere": {"radius": 0.01}}}
    keys = {"links": {"lid": {**lid, "joint": {"type": "revolute", "limits": [0, 1], "axis": [0, 0, 1]}}}}
    outcome = exported(robot_of(kit.document, plan_of(**keys)), **keys)
    assert only_dof(outcome)["provenance"] == dict(zip(QUANTITIES, ("given", "given", *UNSET), strict=True))
