"""Joints in the user's own terms: zero, direction, rotor; what drives them in a source's file."""

import functools

import mujoco
import numpy as np
import pytest
from lxml import etree

from linkwright.stages.export import export
from linkwright.stages.formats.urdf.transmission_counts import with_counts
from linkwright.stages.graph.passes.limits.joint_limits import with_properties
from linkwright.stages.graph.passes.zero_pose import with_zero
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Limits, MateValue, Relation, Robot
from tests.support.building import NO_MESHES, plan_of
from tests.support.mjcfs import body, model, robot_of, written
from tests.support.robots import joint, robot_with


def counted(robot: Robot, zero="mate", **joints) -> tuple[Robot, Diagnostics]:
    keys, log = GraphSections(joints=joints).joints, Diagnostics()
    robot = with_properties(robot, keys, log)
    return with_zero(robot, zero, keys, log), log


@pytest.fixture
def arm():
    limits = {"elbow": Limits(-0.5, 1.0), "rail": Limits(0.0, None)}
    return robot_with(
        [
            joint("revolute", "base", "upper", [0.2], name="elbow", limits=limits),
            joint("prismatic", "upper", "lower", [0.1], name="rail", limits=limits),
            joint("ball", "lower", "hand", name="wrist"),
        ],
        relations=[Relation("rack", "rail", "elbow", 0.1, 0.05)],
    )


def test_limits_saved_values_and_relations_are_counted_anew(arm):
    robot, log = counted(arm, elbow={"zero": 0.3, "invert": True}, rail={"invert": True})
    elbow, rail, wrist = robot.dofs
    assert not log.found
    assert elbow.limits.interval == pytest.approx((-0.7, 0.8))
    assert elbow.saved == pytest.approx(0.1)
    assert (rail.limits, rail.saved) == (Limits(None, 0.0), -0.1)
    assert wrist.in_mate == MateValue()
    (rack,) = robot.relations
    # rail = 0.1 elbow + 0.05, with elbow = 0.3 − elbow' and rail = −rail'.
    assert (rack.multiplier, rack.offset) == pytest.approx((0.1, -0.08))


def test_limits_are_in_the_mates_own_value(arm):
    robot, _ = counted(arm, elbow={"zero": 1.0, "invert": True, "limits": [0.0, 2.0]})
    assert robot.dofs[0].limits == Limits(-1.0, 1.0)


def test_a_joints_own_zero_goes_before_that_of_all(arm):
    robot, _ = counted(arm, "saved", **{"*": {"invert": True}, "rail": {"zero": 0.02, "invert": False}})
    elbow, rail, _ = robot.dofs
    assert (elbow.in_mate, elbow.saved) == (MateValue(-1, 0.2), 0.0)
    assert (rail.in_mate, rail.saved) == (MateValue(1, 0.02), pytest.approx(0.08))


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ({"wrist": {"invert": True}}, "'wrist' matches only balls or free joints, which have no invert"),
        ({"*": {"zero": 0.3}}, "'*' gives one zero to dofs of several kinds: elbow (turn), rail (slide)"),
        ({"elbow": {"gear": 50}}, "'elbow' gives a gear to joints that have no rotor_inertia"),
        ({"wrist": {"rotor_inertia": 1e-5}}, ""),
        ({"*": {"zero": 0.0, "invert": True}}, None),
    ],
)
def test_what_cannot_be_is_named(arm, joints, message):
    problems = [(problem.code, problem.message) for problem in counted(arm, **joints)[1].problems]
    assert [code for code, _ in problems] == ([] if message is None else ["E-JOINT"])
    assert not message or problems[0][1] == message


def test_the_armature_is_the_rotors_by_the_gear_squared(arm):
    rotors = {"elbow": {"rotor_inertia": 2e-5}, "rail": {"rotor_inertia": 1e-5}}
    robot, log = counted(arm, **{"*": {"gear": 10, "armature": 7}, **rotors})
    assert not log.problems
    assert [dof.dynamics.armature for dof in robot.dofs] == [pytest.approx(2e-3), pytest.approx(1e-3), 7]
    robot, _ = counted(arm, elbow={"rotor_inertia": 2e-5}, **{"elbo*": {"armature": 0.3}})
    assert (robot.dofs[0].dynamics.armature, robot.dofs[0].given) == (0.3, ("armature",))


ACTUATORS = """
<actuator>
  <position joint="slew" kp="30" kv="2" ctrlrange="-1 2" gear="2"/>
  <motor joint="slew" ctrlrange="-3 5" gear="-4" forcerange="-1 2"/>
  <velocity joint="slew" kv="3" ctrlrange="-1 4"/>
  <damper joint="slew" kv="3" ctrlrange="0 4"/>
  <intvelocity joint="slew" kp="20" actrange="-1 1.5" ctrlrange="-1 4"/>
  <general joint="slew" gaintype="affine" gainprm="2 -3 0.5" biastype="affine" biasprm="1 -7 -0.3"/>
  <general joint="slew" gainprm="5" biastype="affine" biasprm="1 -7 -0.3" gear="3" ctrlrange="-1 4"/>
  <general joint="slew" dyntype="filter" dynprm="0.1" gainprm="5" biastype="affine" biasprm="0 -5"
    ctrlrange="-1 2" actlimited="true" actrange="-1 2"/>
</actuator>
"""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """The model of an arm whose joint has these keys."""
    text = model(body("arm", '<joint name="slew" axis="0 1 0"/>'), ACTUATORS)
    path = written(tmp_path_factory.mktemp("slew"), text)

    @functools.cache
    def engine(**keys):
        joints = {"slew": keys} if keys else {}
        mjcf = export(robot_of(path, joints=joints), NO_MESHES, plan_of(joints=joints)).files["robot.xml"]
        return mujoco.MjModel.from_xml_string(mjcf.decode())

    return engine


@pytest.mark.parametrize("keys", [{"invert": True}, {"zero": 0.4}, {"zero": -0.3, "invert": True}])
def test_a_sources_actuators_pull_as_before(keys, compiled):
    """Forces at equal poses and speeds, as MuJoCo has them of both files, controls counted as told: a
    servo's as the joint's value, a damper's as it is."""
    old, new = compiled(), compiled(**keys)
    sign, zero = (-1 if keys.get("invert") else 1), keys.get("zero", 0.0)
    assert old.nu == new.nu == 8
    # Which unit an actuator's control has: of its own length, of a speed or force, or of neither.
    shift, factor = np.zeros(8), np.full(8, sign)
    shift[[0, 7]] = np.array([2, 1]) * zero
    factor[[3, 5]] = 1
    random = np.random.default_rng(4)
    for _ in range(5):
        q, speed = random.uniform(-1, 1, 2)
        control, state = random.uniform(0, 1, 8), random.uniform(-0.5, 1, old.na)
        outcomes = []
        for engine, (position, velocity, controls, states) in (
            (old, (q, speed, control, state)),
            (new, (sign * (q - zero), sign * speed, factor * (control - shift), sign * (state - zero))),
        ):
            data = mujoco.MjData(engine)
            data.qpos[:], data.qvel[:], data.ctrl[:], data.act[:] = position, velocity, controls, states
            mujoco.mj_forward(engine, data)
            outcomes.append(np.concatenate([data.qfrc_actuator, data.actuator_force, data.act_dot]))
        assert outcomes[1] == pytest.approx(sign * outcomes[0], rel=1e-9, abs=1e-9)
    ranges = np.sort(factor[:, None] * (old.actuator_ctrlrange - shift[:, None]))
    assert new.actuator_ctrlrange == pytest.approx(np.where(old.actuator_ctrllimited[:, None], ranges, 0))


CONTROL = """
<ros2_control name="c" type="system"><hardware><plugin>p</plugin></hardware>
<joint name="slew"><command_interface name="position">
    <param name="min">-1</param><param name="max">2</param></command_interface>
  <command_interface name="velocity">
    <param name="min">-3</param><param name="max">4</param></command_interface>
  <state_interface name="position"><param name="initial_value">0.5</param></state_interface></joint>
<joint name="other">
  <command_interface name="position"><param name="min">-1</param></command_interface></joint>
<transmission name="t"><actuator name="a"/>
  <joint name="slew"><mechanical_reduction>50</mechanical_reduction></joint></transmission></ros2_control>
"""


def test_a_ros2_controls_ranges_are_counted_anew():
    tree = etree.fromstring(with_counts(CONTROL, {"slew": MateValue(-1, 0.5), "other": MateValue()}))

    def values(path: str) -> dict[str, str]:
        return {element.get("name"): element.text for element in tree.findall(f"joint[@name='{path}/param")}

    assert values("slew']/command_interface[@name='position']") == {"max": "1.5", "min": "-1.5"}
    assert values("slew']/command_interface[@name='velocity']") == {"max": "3", "min": "-4"}
    assert values("slew']/state_interface") == {"initial_value": "0"}
    assert values("other']/command_interface") == {"min": "-1"}
    # actuator / 50 is the mate's own value: the new one is 0.5 − actuator / 50.
    counts = {element.tag: float(element.text) for element in tree.find("transmission/joint")}
    assert counts == {"mechanical_reduction": -50, "offset": 0.5}
    assert with_counts(CONTROL, {"slew": MateValue()}) == CONTROL
