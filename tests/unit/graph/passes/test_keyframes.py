"""The key `keyframes`: values by glob, each checked, and the rest of the robot near to home."""

import math

import mujoco
import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.graph.passes.keyframes import with_keyframes
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Limits, Relation
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loops import gap
from linkwright.stages.robot.motion.start_pose import home, keyframes, saved, starting_point
from tests.support.building import NO_MESHES, plan_of
from tests.support.robots import joint, robot_with
from tests.unit.robot.test_home import four_bar


def legs(**more):
    """Two legs of a hip and a knee each, saved at 0.2 rad, and a wheel that the first hip drives."""
    limits = {f"{name}_{part}": Limits(-1.0, 2.0) for name in ("left", "right") for part in ("hip", "knee")}
    joints = []
    for side in ("left", "right"):
        joints.append(
            joint("revolute", "base", f"{side}_thigh", name=f"{side}_hip", saved=[0.2], limits=limits)
        )
        knee = joint(
            "revolute", f"{side}_thigh", f"{side}_shin", name=f"{side}_knee", saved=[0.2], limits=limits
        )
        joints.append(knee)
    joints.append(joint("revolute", "base", "wheel", name="wheel", saved=[0.5]))
    joints.append(joint("ball", "base", "head", name="neck"))
    relations = [Relation("belt", "wheel", "left_hip", 2.0, 0.1)]
    return robot_with(joints, relations=relations, **more)


def leg(saved_at, limits):
    return robot_with(
        [joint("revolute", "base", "leg", name="hip", saved=[saved_at], limits={"hip": limits})]
    )


def made(robot, wanted):
    log = Diagnostics()
    return with_keyframes(robot, wanted, log), log


def test_globs_give_values_and_the_others_stay_at_home():
    robot, log = made(legs(), {"crouch": {"*_knee": 1.2, "left_knee": 1.4}, "home": {"*_hip": -0.3}})
    assert not log.problems
    poses = keyframes(robot)
    assert list(poses) == ["home", "cad", "crouch"]
    assert poses["home"] == home(robot)
    assert {name: poses["home"][name] for name in ("left_hip", "right_hip", "left_knee", "wheel")} == {
        "left_hip": -0.3, "right_hip": -0.3, "left_knee": 0.2, "wheel": pytest.approx(-0.5),
    }  # fmt: skip
    assert poses["cad"] == saved(robot)
    assert [poses["crouch"][f"{side}_knee"] for side in ("left", "right")] == [1.4, 1.2]
    assert poses["crouch"]["left_hip"] == -0.3


def test_the_value_of_a_follower_moves_its_driver():
    robot, log = made(legs(), {"turned": {"wheel": 0.7}})
    assert not log.problems
    assert keyframes(robot)["turned"]["left_hip"] == pytest.approx(0.3)
    assert keyframes(robot)["turned"]["wheel"] == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("wanted", "code", "said"),
    [
        ({"a": {"*_knie": 1.0}}, "E-GLOB", "joints are: left_hip"),
        ({"a": {"left_knee": 2.5}}, "E-KEYFRAME", "2.5 rad is outside the limits of left_knee, -1 to 2"),
        ({"a": {"neck": 1.0}}, "E-KEYFRAME", "no single value"),
        ({"cad": {"left_knee": 1.0}}, "E-KEYFRAME", "saved in CAD"),
        ({"a": {"left_hip": 0.5, "wheel": 0.5}}, "E-KEYFRAME", "makes wheel 1.1, not 0.5"),
    ],
)
def test_a_value_that_cannot_be_is_named(wanted, code, said):
    _, log = made(legs(), wanted)
    (problem,) = log.problems
    assert problem.code == code
    assert problem.where == f"keyframes.{next(iter(wanted))}"
    assert said in f"{problem.message} {problem.hint}"


def test_the_rest_of_a_loop_follows_and_too_much_of_it_is_refused():
    robot, log = made(four_bar(), {"half": {"drive": 1.4}})
    assert not log.problems
    pose = keyframes(robot)["half"]
    assert pose["drive"] == 1.4
    assert gap(robot.loops[0], link_poses(robot, pose)) < 1e-9
    wanted = {"bent": {"drive": 1.4, "swing": pose["swing"] + 0.3, "pin": pose["pin"]}}
    (problem,) = made(four_bar(), wanted)[1].problems
    assert (problem.code, problem.where) == ("E-KEYFRAME", "keyframes.bent")
    assert "no pose with these values closes loop" in problem.message


def test_a_home_that_no_pose_closes_is_a_warning():
    far = saved(four_bar())
    limits = {
        "drive": Limits(1.3, 2.0),
        "pin": Limits(far["pin"] + 2, None),
        "swing": Limits(None, far["swing"] - 2),
    }
    (found,) = made(four_bar(limits), {})[1].found
    assert (found.code, found.where) == ("W-HOME", "loop")


def test_a_simulation_starts_at_home_where_zero_or_the_saved_pose_is_outside_the_limits():
    limits = {"hip": Limits(0.3, 1.0)}
    robot = robot_with([joint("revolute", "base", "leg", name="hip", saved=[0.1], limits=limits)])
    assert starting_point(robot) == home(robot) == {"hip": 0.3}
    within = robot_with(
        [joint("revolute", "base", "leg", name="hip", saved=[0.5], limits={"hip": Limits(-1, 1)})]
    )
    assert starting_point(within) == {"hip": 0.0}
    bar = four_bar({"drive": Limits(1.3, 2.0)})
    assert starting_point(bar) == home(bar)
    assert gap(bar.loops[0], link_poses(bar, starting_point(bar))) < 1e-9


def test_the_mjcf_has_each_keyframe_and_starts_within_the_limits():
    robot, _ = made(leg(0.1, Limits(0.3, 1.0)), {"kick": {"hip": 0.9}})
    files = export(robot, NO_MESHES, plan_of()).files
    model = mujoco.MjModel.from_xml_string(files[f"{robot.name}.xml"].decode())
    assert model.qpos0.tolist() == [0.3]
    assert {model.key(index).name: model.key(index).qpos.tolist() for index in range(model.nkey)} == {
        "home": [0.3], "cad": [0.1], "kick": [0.9],
    }  # fmt: skip
    data = mujoco.MjData(model)
    for name, pose in keyframes(robot).items():
        mujoco.mj_resetDataKeyframe(model, data, model.key(name).id)
        mujoco.mj_kinematics(model, data)
        found = np.eye(4)
        found[:3, :3] = data.body("leg").xmat.reshape(3, 3)
        found[:3, 3] = data.body("leg").xpos
        np.testing.assert_allclose(found, link_poses(robot, pose)["leg"], atol=1e-12)
    assert math.isclose(model.jnt_range[0][0], 0.3)


def test_the_servos_of_each_keyframe_rest_there():
    robot, _ = made(leg(0.1, Limits(0.0, 1.0)), {"kick": {"hip": 0.9}})
    plan = plan_of(actuators={"*": {"type": "position", "kp": 10}})
    files = export(robot, NO_MESHES, plan).files
    model = mujoco.MjModel.from_xml_string(files[f"{robot.name}.xml"].decode())
    assert {model.key(index).name: model.key(index).ctrl.tolist() for index in range(model.nkey)} == {
        "home": [0.1], "cad": [0.1], "kick": [0.9],
    }  # fmt: skip
