"""The key `keyframes`: values by glob, each checked, and the rest of the robot near to home."""

import mujoco
import numpy as np
import pytest

from linkwright.stages.graph.passes.keyframes import with_keyframes
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Limits, Relation
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loops import gap
from linkwright.stages.robot.motion.start_pose import home, keyframes, saved, starting_point
from tests.support.exports import compiled, exported
from tests.support.mjcfs import body, model, rebuilt, written
from tests.support.reported import only
from tests.support.robots import joint, robot_with
from tests.unit.robot.test_home import four_bar


def legs(**more):
    """Two legs of a hip and a knee each, saved at 0.2 rad, and a wheel that the first hip drives."""
    joints = []
    for side in ("left", "right"):
        for above, below, part in (("base", "thigh", "hip"), (f"{side}_thigh", "shin", "knee")):
            name = f"{side}_{part}"
            more_of = {"name": name, "saved": [0.2], "limits": {name: Limits(-1.0, 2.0)}}
            joints.append(joint("revolute", above, f"{side}_{below}", **more_of))
    joints.append(joint("revolute", "base", "wheel", name="wheel", saved=[0.5]))
    joints.append(joint("ball", "base", "head", name="neck"))
    return robot_with(joints, relations=[Relation("belt", "wheel", "left_hip", 2.0, 0.1)], **more)


def leg(saved_at, *limits):
    hip = joint("revolute", "base", "leg", name="hip", saved=[saved_at], limits={"hip": Limits(*limits)})
    return robot_with([hip])


def made(robot, sections):
    log = Diagnostics()
    return with_keyframes(robot, sections, log), log


def test_globs_give_values_and_the_others_stay_at_home():
    robot, log = made(legs(), {"crouch": {"*_knee": 1.2, "left_knee": 1.4}, "home": {"*_hip": -0.3}})
    assert not log.problems
    poses = keyframes(robot)
    assert list(poses) == ["home", "cad", "crouch"]
    assert (poses["home"], poses["cad"]) == (home(robot), saved(robot))
    at_home = {"left_hip": -0.3, "right_hip": -0.3, "left_knee": 0.2, "wheel": pytest.approx(-0.5)}
    assert {name: poses["home"][name] for name in at_home} == at_home
    assert [poses["crouch"][name] for name in ("left_knee", "right_knee", "left_hip")] == [1.4, 1.2, -0.3]


def test_the_value_of_a_follower_moves_its_driver():
    robot, log = made(legs(), {"turned": {"wheel": 0.7}})
    assert not log.problems
    assert keyframes(robot)["turned"]["left_hip"] == pytest.approx(0.3)
    assert keyframes(robot)["turned"]["wheel"] == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("sections", "code", "said"),
    [
        ({"a": {"*_knie": 1.0}}, "E-GLOB", "joints are: left_hip"),
        ({"a": {"left_knee": 2.5}}, "E-KEYFRAME", "2.5 rad is outside the limits of left_knee, -1 to 2"),
        ({"a": {"neck": 1.0}}, "E-KEYFRAME", "no single value"),
        ({"cad": {"left_knee": 1.0}}, "E-KEYFRAME", "saved in CAD"),
        ({"a": {"left_hip": 0.5, "wheel": 0.5}}, "E-KEYFRAME", "makes wheel 1.1, not 0.5"),
    ],
)
def test_a_value_that_cannot_be_is_named(sections, code, said):
    problem = only(made(legs(), sections)[1])
    assert (problem.code, problem.where) == (code, f"keyframes.{next(iter(sections))}")
    assert said in f"{problem.message} {problem.hint}"


def test_the_rest_of_a_loop_follows_and_too_much_is_refused():
    robot, log = made(four_bar(), {"half": {"drive": 1.4}})
    assert not log.problems
    pose = keyframes(robot)["half"]
    assert pose["drive"] == 1.4
    assert gap(robot.loops[0], link_poses(robot, pose)) < 1e-9
    bent = {"bent": {"drive": 1.4, "swing": pose["swing"] + 0.3, "pin": pose["pin"]}}
    problem = only(made(four_bar(), bent)[1])
    assert (problem.code, problem.where) == ("E-KEYFRAME", "keyframes.bent")
    assert "no pose with these values closes loop" in problem.message


def test_a_home_that_no_pose_closes_is_a_warning():
    far, drive = saved(four_bar()), Limits(1.3, 2.0)
    limits = {"drive": drive, "pin": Limits(far["pin"] + 2, None), "swing": Limits(None, far["swing"] - 2)}
    note = only(made(four_bar(limits), {})[1])
    assert (note.code, note.where) == ("W-HOME", "loop")


def test_a_simulation_starts_at_home_where_zero_is_outside():
    robot = leg(0.1, 0.3, 1.0)
    assert starting_point(robot) == home(robot) == {"hip": 0.3}
    assert starting_point(leg(0.5, -1, 1)) == {"hip": 0.0}
    bar = four_bar({"drive": Limits(1.3, 2.0)})
    assert starting_point(bar) == home(bar)
    assert gap(bar.loops[0], link_poses(bar, starting_point(bar))) < 1e-9


TOP = {"child": "torso", "xyz": [0.1, 0, -0.2], "rpy": [0.3, 0, 0], "mass": 1, "inertia": [1, 1, 1, 0, 0, 0]}


@pytest.mark.parametrize(
    "keys",
    [
        {"root": {"select": "leg"}},
        {"root": {"frame": "chest"}, "frames": {"include": ["*"]}},
        {"links": {"top": TOP}},
    ],
)
def test_a_sources_keyframe_places_whatever_root_is_chosen(keys, tmp_path):
    leg_body = body("leg", '<joint name="hip" axis="0 1 0" pos="0 0 .1"/>', pos="0 .1 .3", euler="0 0 1")
    inside = f'<freejoint/><site name="chest" pos=".1 .2 .3" euler="1 0 0"/>{leg_body}'
    world = '<geom type="plane" size="0 0 1"/>' + body("torso", inside, pos="0 0 1")
    key = '<keyframe><key name="up" qpos="1 2 3 .5 .5 -.5 .5 .7"/></keyframe>'
    path = written(tmp_path, model(world, key))
    source, target = mujoco.MjModel.from_xml_path(str(path)), compiled(rebuilt(path, **keys))
    poses = []
    for engine in (source, target):
        data = mujoco.MjData(engine)
        mujoco.mj_resetDataKeyframe(engine, data, engine.key("up").id)
        mujoco.mj_forward(engine, data)
        poses.append(np.array([data.body(name).xipos for name in ("torso", "leg")]))
    assert np.abs(poses[0] - poses[1]).max() < 1e-6


def test_the_mjcf_has_each_keyframe_and_starts_within_the_limits():
    robot, _ = made(leg(0.1, 0.3, 1.0), {"kick": {"hip": 0.9}})
    model = compiled(exported(robot))
    assert (model.qpos0.tolist(), model.jnt_range[0][0]) == ([0.3], pytest.approx(0.3))
    poses = {model.key(index).name: model.key(index).qpos.tolist() for index in range(model.nkey)}
    assert poses == {"home": [0.3], "cad": [0.1], "kick": [0.9]}
    data = mujoco.MjData(model)
    for name, pose in keyframes(robot).items():
        mujoco.mj_resetDataKeyframe(model, data, model.key(name).id)
        mujoco.mj_kinematics(model, data)
        expected = link_poses(robot, pose)["leg"]
        np.testing.assert_allclose(data.body("leg").xmat.reshape(3, 3), expected[:3, :3], atol=1e-12)
        np.testing.assert_allclose(data.body("leg").xpos, expected[:3, 3], atol=1e-12)


def test_the_servos_of_each_keyframe_rest_there():
    robot, _ = made(leg(0.1, 0.0, 1.0), {"kick": {"hip": 0.9}})
    model = compiled(exported(robot, actuators={"*": {"type": "position", "kp": 10}}))
    controls = {model.key(index).name: model.key(index).ctrl.tolist() for index in range(model.nkey)}
    assert controls == {"home": [0.1], "cad": [0.1], "kick": [0.9]}
