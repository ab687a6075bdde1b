"""Joints in the user's own terms: zero, direction, rotor; what drives them in a source's file."""

import mujoco
import numpy as np
import pytest
from lxml import etree

from linkwright.stages.formats.urdf.transmission_counts import with_counts
from linkwright.stages.graph.passes.limits.joint_limits import with_properties
from linkwright.stages.graph.passes.zero_pose import with_zero
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Limits, MateValue, Relation, Robot
from tests.support.building import plan_of, write
from tests.support.mjcfs import body, model, robot_of, written
from tests.support.robots import joint, robot_with


def counted(robot: Robot, zero="mate", **joints) -> tuple[Robot, Diagnostics]:
    keys, log = GraphSections(joints=joints).joints, Diagnostics()
    robot = with_properties(robot, keys, log)
    return with_zero(robot, zero, keys, log), log


@pytest.fixture
def arm() -> Robot:
    limits = {"elbow": Limits(-0.5, 1.0), "rail": Limits(0.0, None)}
    return robot_with(
        [
            joint("revolute", "base", "upper", [0.2], name="elbow", limits=limits),
            joint("prismatic", "upper", "lower", [0.1], name="rail", limits=limits),
            joint("ball", "lower", "hand", name="wrist"),
        ],
        relations=[Relation("rack", "rail", "elbow", 0.1, 0.05)],
    )


def test_limits_saved_values_and_relations_are_counted_anew(arm: Robot) -> None:
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


def test_limits_are_in_the_mates_own_value(arm: Robot) -> None:
    robot, _ = counted(arm, elbow={"zero": 1.0, "invert": True, "limits": [0.0, 2.0]})
    assert robot.dofs[0].limits == Limits(-1.0, 1.0)


def test_a_joints_own_zero_goes_before_that_of_all(arm: Robot) -> None:
    robot, _ = counted(arm, "saved", **{"*": {"invert": True}, "rail": {"zero": 0.02, "invert": False}})
    elbow, rail, _ = robot.dofs
    assert (elbow.in_mate, elbow.saved) == (MateValue(-1, 0.2), 0.0)
    assert (rail.in_mate, rail.saved) == (MateValue(1, 0.02), pytest.approx(0.08))


def test_what_cannot_be_is_named(arm: Robot) -> None:
    def told(**joints):
        return [(one.code, one.message) for one in counted(arm, **joints)[1].problems]

    assert told(wrist={"invert": True}) == [
        ("E-JOINT", "'wrist' matches only balls or free joints, which have no invert")
    ]
    assert told(**{"*": {"zero": 0.3}}) == [
        ("E-JOINT", "'*' gives one zero to dofs of several kinds: elbow (turn), rail (slide)")
    ]
    assert told(elbow={"gear": 50}) == [
        ("E-JOINT", "'elbow' gives a gear to joints that have no rotor_inertia")
    ]
    assert told(wrist={"rotor_inertia": 1e-5})[0][0] == "E-JOINT"
    assert not told(**{"*": {"zero": 0.0, "invert": True}})


def test_the_armature_is_the_rotors_inertia_times_the_gear_squared(arm: Robot) -> None:
    robot, log = counted(
        arm,
        **{
            "*": {"gear": 10, "armature": 7},
            "elbow": {"rotor_inertia": 2e-5},
            "rail": {"rotor_inertia": 1e-5},
        },
    )
    assert not log.problems
    assert [dof.dynamics.armature for dof in robot.dofs] == [pytest.approx(2e-3), pytest.approx(1e-3), 7]
    robot, _ = counted(arm, elbow={"rotor_inertia": 2e-5}, **{"elbo*": {"armature": 0.3}})
    assert robot.dofs[0].dynamics.armature == 0.3
    assert robot.dofs[0].given == ("armature",)


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


@pytest.mark.parametrize("keys", [{"invert": True}, {"zero": 0.4}, {"zero": -0.3, "invert": True}])
def test_a_sources_actuators_pull_as_before(keys: dict, tmp_path) -> None:
    """Forces at equal poses and speeds, as MuJoCo has them of both files, controls counted as told: a
    servo's as the joint's value, a damper's as it is."""
    path = written(tmp_path, model(body("arm", '<joint name="slew" axis="0 1 0"/>'), ACTUATORS))
    engines = []
    for name, own in (("old", {}), ("new", keys)):
        plan = plan_of(joints={"slew": own} if own else {})
        folder = tmp_path / name
        folder.mkdir()
        write(robot_of(path, joints={"slew": own} if own else {}), folder, plan)
        engines.append(mujoco.MjModel.from_xml_path(str(folder / "robot.xml")))
    sign, zero = (-1 if keys.get("invert") else 1), keys.get("zero", 0.0)
    old, new = engines
    assert old.nu == new.nu == 8
    random = np.random.default_rng(4)
    for _ in range(5):
        q, speed = random.uniform(-1, 1, 2)
        control = random.uniform(0, 1, 8)
        # Which unit an actuator's control has: of its own length, of a speed or force, or of neither.
        length = [0, 7]
        neither = [3, 5]
        shift = np.zeros(8)
        shift[length] = np.array([2, 1]) * zero
        factor = np.where(np.isin(range(8), neither), 1, sign)
        state = random.uniform(-0.5, 1, old.na)
        moved_state = sign * (state - zero)
        forces = []
        for engine, values in (
            (old, (q, speed, control, state)),
            (new, (sign * (q - zero), sign * speed, factor * (control - shift), moved_state)),
        ):
            data = mujoco.MjData(engine)
            data.qpos[:], data.qvel[:], data.ctrl[:] = values[:3]
            data.act[:] = values[3]
            mujoco.mj_forward(engine, data)
            forces.append((data.qfrc_actuator.copy(), data.actuator_force.copy(), data.act_dot.copy()))
        (before, each, rate), (after, each_now, rate_now) = forces
        assert after == pytest.approx(sign * before, rel=1e-9, abs=1e-9)
        assert each_now == pytest.approx(sign * each, rel=1e-9, abs=1e-9)
        assert rate_now == pytest.approx(sign * rate, rel=1e-9, abs=1e-9)
    ranges = np.sort(factor[:, None] * (old.actuator_ctrlrange - shift[:, None]))
    assert new.actuator_ctrlrange == pytest.approx(np.where(old.actuator_ctrllimited[:, None], ranges, 0))


CONTROL = """
<ros2_control name="c" type="system">
  <hardware><plugin>p</plugin></hardware>
  <joint name="slew">
    <command_interface name="position">
      <param name="min">-1</param><param name="max">2</param>
    </command_interface>
    <command_interface name="velocity">
      <param name="min">-3</param><param name="max">4</param>
    </command_interface>
    <state_interface name="position"><param name="initial_value">0.5</param></state_interface>
  </joint>
  <joint name="other">
    <command_interface name="position"><param name="min">-1</param></command_interface>
  </joint>
  <transmission name="t">
    <actuator name="a"/>
    <joint name="slew"><mechanical_reduction>50</mechanical_reduction></joint>
  </transmission>
</ros2_control>
"""


def test_a_ros2_controls_ranges_are_counted_anew() -> None:
    tree = etree.fromstring(with_counts(CONTROL, {"slew": MateValue(-1, 0.5), "other": MateValue()}))

    def values(path: str) -> dict[str, str]:
        return {one.get("name"): one.text for one in tree.findall(f"{path}/param")}

    slew = "joint[@name='slew']/command_interface[@name='{}']"
    assert values(slew.format("position")) == {"max": "1.5", "min": "-1.5"}
    assert values(slew.format("velocity")) == {"max": "3", "min": "-4"}
    assert values("joint[@name='slew']/state_interface") == {"initial_value": "0"}
    assert values("joint[@name='other']/command_interface") == {"min": "-1"}
    (of_actuator,) = tree.findall("transmission/joint")
    # actuator / 50 is the mate's own value: the new one is 0.5 − actuator / 50.
    assert {one.tag: float(one.text) for one in of_actuator} == {"mechanical_reduction": -50, "offset": 0.5}
    assert with_counts(CONTROL, {"slew": MateValue()}) == CONTROL
