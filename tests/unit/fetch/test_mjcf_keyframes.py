"""Keyframes of an MJCF are keyframes of the robot, and what a keyframe of ours cannot have is named."""

import mujoco
import numpy as np
import pytest

from linkwright.stages.robot.errors import AssemblyError
from tests.support.exports import compiled, messages_of
from tests.support.mjcfs import SOLID, body, model, rebuilt, robot_of, written

pytestmark = pytest.mark.usefixtures("guests_at_home")

GEOM = '<geom type="capsule" fromto="0 0 0 0 0 -.2" size=".02"/>'
LEG = body(
    "thigh",
    '<joint name="hip" axis="0 1 0" range="-1 1" ref=".3"/>'
    + GEOM
    + body("shin", GEOM + '<joint name="knee" axis="0 1 0" range="-2 0"/>', pos="0 0 -.2"),
)
BASE = f'<body name="base" pos="0 0 1"><freejoint name="root"/>{SOLID.format(mass=1)}{LEG}</body>'
SERVOS = """<actuator><position name="hip" joint="hip" kp="20"/>
<position name="knee" joint="knee" kp="20" timeconst=".02"/></actuator>"""
KEYS = """<keyframe><key name="home" qpos="1 2 .5 1 0 0 0 .4 -.7"/><key qpos="0 0 1 1 0 0 0 -.9 -1.5"/>
<key name="crouch" qpos="0 0 1 1 0 0 0 .9 -1.5"/></keyframe>"""


def at_keys(robot, names):
    """Keyframe → joint → value, of hinges and slides."""
    scalar = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    joints = [robot.joint(index) for index in range(robot.njnt) if robot.jnt_type[index] in scalar]
    return {
        name: {joint.name: float(robot.key(name).qpos[joint.qposadr[0]]) for joint in joints}
        for name in names
    }


def values_of(robot):
    return {keyframe.name: dict(keyframe.given) for keyframe in robot.keyframes}


def messages(robot, code):
    return " ".join(messages_of(robot, code))


def test_joints_are_at_each_keyframe_as_in_the_source(tmp_path):
    path = written(tmp_path, model(BASE, SERVOS + KEYS))
    robot = robot_of(path)
    assert values_of(robot) == {
        "home": {"hip": 0.4, "knee": -0.7},
        "keyframe_1": {"hip": -0.9, "knee": -1.5},
        "crouch": {"hip": 0.9, "knee": -1.5},
    }
    assert "keyframe" not in messages(robot, "I-MJCF-LEFT")
    original, ours = mujoco.MjModel.from_xml_path(str(path)), compiled(rebuilt(path))
    assert at_keys(ours, ("home", "crouch")) == at_keys(original, ("home", "crouch"))
    # The links stand to each other as they did, wherever the scene puts the robot.
    for name in ("home", "crouch"):
        shins = []
        for form in (original, ours):
            data = mujoco.MjData(form)
            mujoco.mj_resetDataKeyframe(form, data, form.key(name).id)
            mujoco.mj_kinematics(form, data)
            base = data.body("base").xmat.reshape(3, 3)
            shins.append(base.T @ (data.body("shin").xpos - data.body("base").xpos))
        np.testing.assert_allclose(*shins, atol=1e-12)


def test_the_servos_hold_each_keyframe_also_those_with_a_filter(tmp_path):
    ours = compiled(rebuilt(written(tmp_path, model(BASE, SERVOS + KEYS))))
    for name, hip, knee in (("home", 0.4, -0.7), ("crouch", 0.9, -1.5)):
        assert (ours.key(name).ctrl.tolist(), ours.key(name).act.tolist()) == ([hip, knee], [knee])
    data = mujoco.MjData(ours)
    mujoco.mj_resetDataKeyframe(ours, data, ours.key("crouch").id)
    mujoco.mj_forward(ours, data)
    np.testing.assert_allclose(data.actuator_force, 0, atol=1e-9)


def test_our_own_file_keeps_its_keyframes(tmp_path):
    path, files = written(tmp_path, model(BASE, SERVOS + KEYS)), []
    for name in ("first", "second"):
        files.append(rebuilt(path).files["robot.xml"])
        (tmp_path / name).mkdir()
        path = written(tmp_path / name, files[-1].decode())
    first, second = (
        [line for line in data.decode().splitlines() if "<key " in line and 'name="cad"' not in line]
        for data in files
    )
    assert len(first) == 3
    assert first == second


def test_the_users_values_win_and_follow_names_and_signs(tmp_path):
    path = written(tmp_path, model(BASE, '<size nkey="5"/>' + KEYS))
    values = values_of(robot_of(path, keyframes={"home": {"k*": -0.2}, "low": {"hip": 0.1}}))
    crouch = {"hip": 0.9, "knee": -1.5}
    assert values == {
        "home": {"hip": 0.4, "knee": -0.2}, "keyframe_1": {"hip": -0.9, "knee": -1.5}, "crouch": crouch,
        "low": {"hip": 0.1},
    }  # fmt: skip
    keys = {"names": {"joints": {"hip": "swing"}}, "joints": {"knee": {"invert": True}}}
    assert values_of(robot_of(path, **keys))["home"] == {"swing": 0.4, "knee": 0.7}
    # Room for keyframes makes none.
    assert values_of(robot_of(written(tmp_path, model(BASE, '<size nkey="5"/>')))) == {}


def test_a_pose_outside_the_limits_has_the_limit_and_is_named(tmp_path):
    path = written(tmp_path, model(BASE, KEYS))
    limits = {"knee": {"limits": [-0.5, 0]}}
    robot = robot_of(path, joints=limits)
    assert values_of(robot)["home"] == {"hip": 0.4, "knee": -0.5}
    warned = {problem.where: problem for problem in robot.diagnostics if problem.code == "W-KEYFRAME"}
    assert list(warned) == ["home", "keyframe_1", "crouch"]
    assert "knee (-0.7, now -0.5 rad)" in warned["home"].message
    assert "hip" not in warned["home"].message
    assert "`keyframes: {home: null}`" in warned["home"].hint
    # What the user gives in its place is the user's.
    mended = robot_of(path, joints=limits, keyframes={"home": {"knee": -0.3}})
    assert values_of(mended)["home"] == {"hip": 0.4, "knee": -0.3}
    outside = [problem.where for problem in mended.diagnostics if problem.code == "W-KEYFRAME"]
    assert outside == ["keyframe_1", "crouch"]
    # By rounding it has the limit silently, and the saved pose is no keyframe to mend.
    near = robot_of(path, joints={"knee": {"limits": [-1.4999, 0]}})
    assert values_of(near)["crouch"]["knee"] == -1.4999
    key = '<keyframe><key name="cad" qpos="0 0 1 1 0 0 0 .3 0"/></keyframe>'
    saved = robot_of(written(tmp_path, model(BASE, key)), joints={"hip": {"limits": [-1, 0.1]}})
    assert messages(near, "W-KEYFRAME") + messages(saved, "W-KEYFRAME") + messages(saved, "I-KEYFRAME") == ""


def test_a_keyframe_of_the_source_is_left_out_by_null(tmp_path):
    path = written(tmp_path, model(BASE, KEYS))
    robot = robot_of(path, keyframes={"home": None, "keyframe_1": None, "low": {"hip": 0.1}})
    assert sorted(values_of(robot)) == ["crouch", "low"]
    # `home` is then the pose that is nearest to where the source starts.
    ours = at_keys(compiled(rebuilt(path, keyframes={"home": None})), ("home", "cad"))
    assert ours["home"] == ours["cad"] == {"hip": pytest.approx(0.3), "knee": 0.0}
    with pytest.raises(AssemblyError) as error:
        robot_of(path, keyframes={"stand": None})
    (problem,) = error.value.problems
    assert (problem.code, problem.where) == ("E-KEYFRAME", "keyframes.stand")
    assert problem.hint == "the source's keyframes are: crouch, home, keyframe_1"


FOLLOWING = '<equality><joint joint1="knee" joint2="hip" polycoef="-.7 -1 0 0 0"/></equality>'


def test_a_follower_is_left_to_its_driver_but_not_against_it(tmp_path):
    key = '<keyframe><key name="home" qpos="0 0 1 1 0 0 0 .5 {}"/></keyframe>'
    path = written(tmp_path, model(BASE, FOLLOWING + key.format("-.9001")))
    assert values_of(robot_of(path))["home"] == {"hip": 0.5}
    # One value of the two given anew: the other is no longer the source's.
    assert values_of(robot_of(path, keyframes={"home": {"knee": -0.8}}))["home"] == {
        "hip": pytest.approx(0.4)
    }
    path = written(tmp_path, model(BASE, FOLLOWING + key.format("-.5")))
    robot = robot_of(path)
    assert values_of(robot)["home"] == {"hip": 0.5}
    assert "hip = 0.5 makes knee -0.9, not -0.5" in messages(robot, "I-KEYFRAME")


def four_bar(angle, key):
    """A parallelogram whose bars are 0.2 m long and 0.3 m apart, drawn upright."""
    bar = '<geom type="capsule" fromto="0 0 0 0 0 .2" size=".01"/>'
    hinge = '<joint name="{}" axis="0 1 0"/>'
    coupler = body("coupler", hinge.format("pin") + '<site name="end" pos=".3 0 0"/>', pos="0 0 .2")
    left = body("left", hinge.format("drive") + bar + coupler)
    right = body("right", hinge.format("swing") + bar + '<site name="top" pos="0 0 .2"/>', pos=".3 0 0")
    closing = '<equality><connect name="loop" site1="end" site2="top"/></equality>'
    pose = f"{angle} {key}"
    return model(
        body("base", left + right), f'{closing}<keyframe><key name="home" qpos="{pose}"/></keyframe>'
    )


def test_a_rounded_loop_closes_and_an_open_loop_is_refused(tmp_path):
    robot = robot_of(written(tmp_path, four_bar(0.4, "-.4002 .3999")))
    home = values_of(robot)["home"]
    assert [home["drive"]] * 2 == pytest.approx([-home["pin"], home["swing"]], abs=1e-9)
    assert home["drive"] == pytest.approx(0.4, abs=1e-3)
    wrong = written(tmp_path, four_bar(0.4, "-.1 .1"))
    with pytest.raises(AssemblyError, match="the source's keyframe: no pose with these values closes loop"):
        robot_of(wrong)
    mended = robot_of(wrong, keyframes={"home": {"drive": 0.4}})
    assert values_of(mended)["home"] == {"drive": 0.4}


def test_values_that_no_keyframe_can_have_are_named(tmp_path):
    ball = body("head", '<joint name="neck" type="ball"/>')
    world = BASE.replace('<body name="thigh">', ball + '<body name="thigh">')
    world += f'<body name="box"><freejoint name="adrift"/>{SOLID.format(mass=0.1)}</body>'
    world += '<body name="hand" mocap="true" pos="0 1 0"/>'
    muscle = '<actuator><muscle name="biceps" joint="hip" lengthrange="0 1"/></actuator>'
    free = "0 0 1 1 0 0 0"
    still = f'<key name="still" qpos="{free} 1 0 0 0 0 0 0 0 0 1 0 0 0"/>'
    moved = f'<key name="moved" time="2" mpos="0 2 0" qpos="{free} 0 1 0 0 0 0 0 0 1 1 0 0 0" act=".2"/>'
    cad = (
        f'<key name="cad" qpos="{free} 1 0 0 0 .5 0 0 0 0 1 0 0 0" qvel="1 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0"/>'
    )
    path = written(tmp_path, model(world, f"{muscle}<keyframe>{still}{moved}{cad}</keyframe>"))
    robot = robot_of(path)
    left = messages(robot, "I-MJCF-LEFT")
    for words in ("key time (moved)", "key qvel (cad)", "key mpos (moved)", "key act (moved)"):
        assert f"1 × {words}" in left
    assert "mquat" not in left
    reported = {
        problem.where: problem.message for problem in robot.diagnostics if problem.code == "I-KEYFRAME"
    }
    assert sorted(reported) == ["cad", "moved"]
    assert "left out: neck" in reported["moved"]
    assert "moves hip" in reported["cad"]
    assert sorted(values_of(robot)) == ["moved", "still"]
