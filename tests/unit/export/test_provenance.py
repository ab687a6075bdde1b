"""robot.json says of each limit and of effort, velocity and dynamics where it comes from."""

import json

from linkwright.stages.robot.codec import decode_robot, encode_robot
from tests.support.building import plan_of, robot_of, write
from tests.support.kit import SIDE, TOP, Kit

KEYS = ("lower", "upper", "effort", "velocity", "damping", "friction", "armature")


def provenance_of(folder, limits, **keys):
    kit = Kit()
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=limits)
    plan = plan_of(**keys)
    robot = decode_robot(encode_robot(robot_of(kit.document, plan)))
    table = json.loads(write(robot, folder, plan).files["robot.json"])
    ((dof,),) = [joint["dofs"] for joint in table["joints"]]
    return dof["provenance"]


def of(*origins):
    return dict(zip(KEYS, origins, strict=True))


def test_limits_of_the_mate_are_those_of_the_source(tmp_path):
    assert provenance_of(tmp_path, (0, 1)) == of("source", "source", *["unset"] * 5)
    assert provenance_of(tmp_path, (None, 1)) == of("unset", "source", *["unset"] * 5)


def test_what_the_key_joints_gives_is_given(tmp_path):
    joints = {"*": {"effort": 5, "damping": 0.1}, "elbow": {"limits": [None, 0.8]}}
    expected = of("unset", "given", "given", "unset", "given", "unset", "unset")
    assert provenance_of(tmp_path, (0, 1), joints=joints) == expected


def test_an_armature_that_was_chosen_is_estimated(tmp_path):
    driven = provenance_of(tmp_path, (0, 1), actuators={"*": {"type": "position"}})
    assert driven == of("source", "source", *["unset"] * 4, "estimated")


def test_the_joint_of_an_added_link_has_given_limits(tmp_path):
    kit = Kit()
    kit.place("Base", fixed=True)
    lid = {"parent": "base", "mass": 0.1, "geometry": {"sphere": {"radius": 0.01}}}
    plan = plan_of(links={"lid": {**lid, "joint": {"type": "revolute", "limits": [0, 1], "axis": [0, 0, 1]}}})
    table = json.loads(write(robot_of(kit.document, plan), tmp_path, plan).files["robot.json"])
    (dof,) = table["joints"][0]["dofs"]
    assert dof["provenance"] == of("given", "given", *["unset"] * 5)
