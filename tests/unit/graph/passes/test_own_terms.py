"""Joints in the user's own terms: zero, direction, rotor, the saved pose; what they come to in each file."""

import functools
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml
from lxml import etree

from linkwright.stages.formats.urdf.transmission_counts import with_counts
from linkwright.stages.graph.passes.limits.joint_limits import with_limits_and_dynamics
from linkwright.stages.graph.passes.zero_pose import with_zero
from linkwright.stages.graph.section import GraphSections, JointSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import at_rest, rotation_from_quat
from linkwright.stages.robot.model.robot import Limits, MateValue, Relation
from linkwright.stages.robot.motion.kinematics import (
    chain,
    link_poses,
    rest_configuration,
    saved_configuration,
)
from tests.fake_onshape import solids
from tests.fake_onshape.frames import frame
from tests.support.building import plan_of, robot_of
from tests.support.exports import compiled, exported
from tests.support.kit import Kit
from tests.support.mjcfs import body, model, written
from tests.support.mjcfs import robot_of as mjcf_robot
from tests.support.reported import only, reports
from tests.support.robots import CHAINS, EVERY, LOOPS, joint, loop, pose, robot_with, some_value, some_values


def counted(robot, zero="mate", **joints):
    keys, log = GraphSections(joints=joints).joints, Diagnostics()
    robot = with_limits_and_dynamics(robot, keys, log)
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
    assert not log.notes
    assert elbow.limits.interval == pytest.approx((-0.7, 0.8))
    assert elbow.saved == pytest.approx(0.1)
    assert (rail.limits, rail.saved) == (Limits(None, 0.0), -0.1)
    assert wrist.mate_value == MateValue()
    (rack,) = robot.relations
    # rail = 0.1 elbow + 0.05, with elbow = 0.3 − elbow' and rail = −rail'.
    assert (rack.multiplier, rack.offset) == pytest.approx((0.1, -0.08))


def test_limits_are_in_the_mates_own_value(arm):
    robot, _ = counted(arm, elbow={"zero": 1.0, "invert": True, "limits": [0.0, 2.0]})
    assert robot.dofs[0].limits == Limits(-1.0, 1.0)


def test_a_joints_own_zero_goes_before_that_of_all(arm):
    robot, _ = counted(arm, "saved", **{"*": {"invert": True}, "rail": {"zero": 0.02, "invert": False}})
    elbow, rail, _ = robot.dofs
    assert (elbow.mate_value, elbow.saved) == (MateValue(-1, 0.2), 0.0)
    assert (rail.mate_value, rail.saved) == (MateValue(1, 0.02), pytest.approx(0.08))


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
def test_impossible_terms_are_named(arm, joints, message):
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
def engine(tmp_path_factory):
    """The model of an arm whose joint has these keys."""
    text = model(body("arm", '<joint name="slew" axis="0 1 0"/>'), ACTUATORS)
    path = written(tmp_path_factory.mktemp("slew"), text)

    @functools.cache
    def model_with(**keys):
        joints = {"slew": keys} if keys else {}
        return compiled(exported(mjcf_robot(path, joints=joints), joints=joints))

    return model_with


@pytest.mark.parametrize("keys", [{"invert": True}, {"zero": 0.4}, {"zero": -0.3, "invert": True}])
def test_a_sources_actuators_pull_as_before(keys, engine):
    """Forces at equal poses and speeds, as MuJoCo has them of both files, controls counted as told: a
    servo's as the joint's value, a damper's as it is."""
    old, new = engine(), engine(**keys)
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
        for form, (position, velocity, controls, states) in (
            (old, (q, speed, control, state)),
            (new, (sign * (q - zero), sign * speed, factor * (control - shift), sign * (state - zero))),
        ):
            data = mujoco.MjData(form)
            data.qpos[:], data.qvel[:], data.ctrl[:], data.act[:] = position, velocity, controls, states
            mujoco.mj_forward(form, data)
            outcomes.append(np.concatenate([data.qfrc_actuator, data.actuator_force, data.act_dot]))
        assert outcomes[1] == pytest.approx(sign * outcomes[0], rel=1e-9, abs=1e-9)
    ranges = np.sort(factor[:, None] * (old.actuator_ctrlrange - shift[:, None]))
    assert new.actuator_ctrlrange == pytest.approx(np.where(old.actuator_ctrllimited[:, None], ranges, 0))


def test_attributes_that_favour_a_direction_keep_their_direction(tmp_path):
    hinge = '<joint name="slew" axis="0 1 0" actuatorfrcrange="-1 5" stiffness="1 .5 .3" damping="1 .5 .2"/>'
    path = written(tmp_path, model(body("arm", hinge)))
    forces = []
    for joints in ({}, {"slew": {"invert": True}}):
        engine = compiled(exported(mjcf_robot(path, joints=joints), joints=joints))
        data = mujoco.MjData(engine)
        data.qpos[:], data.qvel[:] = (-0.5, -0.3) if joints else (0.5, 0.3)
        mujoco.mj_forward(engine, data)
        forces.append(data.qfrc_passive[0])
    assert engine.jnt_actfrcrange.tolist() == [[-5, 1]]
    assert forces[1] == pytest.approx(-forces[0])


def test_sensors_of_what_is_below_a_body_are_left_out_below_another_root(tmp_path):
    leg = body("leg", '<joint name="hip" axis="0 1 0"/><site name="foot"/>' + body("toe", "<joint/>"))
    on_leg = (
        '<subtreecom name="com" body="leg"/><force name="push" site="foot"/><gyro name="gyro" site="foot"/>'
    )
    sensors = f'<sensor>{on_leg}<subtreecom name="toes" body="toe"/></sensor>'
    path = written(tmp_path, model(body("torso", f"<freejoint/>{leg}"), sensors))
    robot = mjcf_robot(path, root={"select": "leg"})
    assert [sensor.name for sensor in robot.sensors] == ["gyro", "toes"]
    assert "left out: com, push," in only(robot, "W-MJCF-LEFT").message
    assert [sensor.name for sensor in mjcf_robot(path).sensors] == ["com", "push", "gyro", "toes"]


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

    def values(path):
        return {element.get("name"): element.text for element in tree.findall(f"joint[@name='{path}/param")}

    assert values("slew']/command_interface[@name='position']") == {"max": "1.5", "min": "-1.5"}
    assert values("slew']/command_interface[@name='velocity']") == {"max": "3", "min": "-4"}
    assert values("slew']/state_interface") == {"initial_value": "0"}
    assert values("other']/command_interface") == {"min": "-1"}
    # actuator / 50 is the mate's own value: the new one is 0.5 − actuator / 50.
    counts = {element.tag: float(element.text) for element in tree.find("transmission/joint")}
    assert counts == {"mechanical_reduction": -50, "offset": 0.5}
    assert with_counts(CONTROL, {"slew": MateValue()}) == CONTROL


@pytest.mark.parametrize(("inner", "expected"), [
    ('<actuator name="a"/><joint name="slew"/><mechanicalReduction>20</mechanicalReduction>', ["-20"]),
    (
        '<joint name="slew"/><actuator name="a"><mechanicalReduction>20</mechanicalReduction></actuator>',
        ["-20"],
    ),
    ('<joint name="slew"/><actuator name="a"/>', ["-1"]),
    (
        '<joint name="other"/><joint name="slew"/>'
        '<actuator name="a"><mechanicalReduction>20</mechanicalReduction></actuator><actuator name="b"/>',
        ["-1", "20"],
    ),
])  # fmt: skip
def test_reduction_changes_its_sign_wherever_it_is(inner, expected):
    text = with_counts(f'<transmission name="t">{inner}</transmission>', {"slew": MateValue(-1)})
    assert [element.text for element in etree.fromstring(text).iter("{*}*") if element.text] == expected


def zeroed(robot, log):
    """The robot with q = 0 at the saved pose."""
    return with_zero(robot, "saved", {}, log)


def product(first, other):
    """Hamilton's product of quaternions (w, x, y, z)."""
    (a, b, c, d), (e, f, g, h) = first, other
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


def after(saved, q):
    """The value that moves as `saved` does and then as `q`."""
    if isinstance(saved, float):
        return saved + q
    if len(saved) == 4:
        return product(saved, q)
    place = rotation_from_quat(np.array(saved[3:])) @ np.array(q[:3]) + np.array(saved[:3])
    return (*map(float, place), *product(saved[3:], q[3:]))


def every_joint(seed):
    """A chain of all types, forwards, backwards and mirrored, saved somewhere, with origins between."""
    rng = np.random.default_rng(seed)
    joints, parent = [], "base"
    for number, kind in enumerate(kind for kind in EVERY for _ in range(3)):
        name = f"link_{number}"
        values = [some_value(freedom, rng) for _, freedom, _ in CHAINS[kind]]
        origins = [pose(rng) for _ in CHAINS[kind][1:]]
        way = {"backwards": number % 3 == 1, "mirrored": number % 3 == 2}
        joints.append(joint(kind, parent, name, values, place=pose(rng), origins=origins, **way))
        parent = name
    loops = []
    for kind in LOOPS:
        frames, values = (pose(rng), pose(rng)), [some_value(freedom, rng) for _, freedom, _ in CHAINS[kind]]
        loops.append(loop(kind, "link_1", "link_4", *frames, values, name=f"loop_{kind}"))
    return robot_with(joints, loops=loops)


@pytest.mark.parametrize("seed", range(3))
def test_links_stay_at_values_counted_from_the_saved_pose(seed):
    robot = every_joint(seed)
    moved = zeroed(robot, Diagnostics())
    q = some_values(robot, np.random.default_rng(seed + 100))
    saved = saved_configuration(robot)
    both = {name: after(saved[name], q[name]) for name in q}
    want = link_poses(robot, both)
    for name, place in link_poses(moved, q).items():
        assert np.abs(place - want[name]).max() < 1e-9
    want = link_poses(robot, saved)
    for name, place in link_poses(moved, rest_configuration(moved)).items():
        assert np.abs(place - want[name]).max() < 1e-12
    assert all(dof.saved == at_rest(dof.kind) for dof in moved.dofs)
    assert all((j.dofs[0].origin == np.eye(4)).all() for j in moved.joints if j.dofs)


def test_loops_close_at_values_counted_from_the_saved_pose():
    rng = np.random.default_rng(7)
    robot = every_joint(3)
    for before, now in zip(robot.loops, zeroed(robot, Diagnostics()).loops, strict=True):
        q = {dof.name: some_value(dof.kind, rng) for dof in before.dofs}
        both = {dof.name: after(dof.saved, q[dof.name]) for dof in before.dofs}
        shut = before.b_from_frame @ chain(before.dofs, both)
        assert np.abs(now.b_from_frame @ chain(now.dofs, q) - shut).max() < 1e-12
        assert (now.a_from_frame == before.a_from_frame).all()


def test_limits_and_relations_say_the_same_of_the_shifted_values():
    limits = {"one_joint": Limits(-1.0, None), "two_joint": Limits(0.1, 0.4)}
    joints = [
        joint("revolute", "base", "one", [0.5], limits=limits),
        joint("prismatic", "base", "two", [0.1], limits=limits, backwards=True),
        joint("revolute", "base", "three", [-1.3]),
    ]
    relations = [
        Relation("a", "two_joint", "one_joint", 0.2, 1e-17),
        Relation("b", "three_joint", "one_joint", -2.0, 0.7),
    ]
    robot = robot_with(joints, relations=relations)
    moved = zeroed(robot, Diagnostics())
    assert [dof.limits for dof in moved.dofs] == [Limits(-1.5, None), Limits(0.0, 0.4 - 0.1), Limits()]
    q, saved = 0.37, saved_configuration(robot)
    for before, now in zip(robot.relations, moved.relations, strict=True):
        want = before.multiplier * (saved["one_joint"] + q) + before.offset - saved[before.follower]
        assert now.multiplier * q + now.offset == pytest.approx(want, abs=1e-12)
    # −2 · 0.5 + 0.7 + 1.3 is the one relation that its saved pose breaks: by 1.
    assert [relation.offset for relation in moved.relations] == [0.0, pytest.approx(1.0)]


def test_a_ball_with_a_cone_keeps_its_zero_and_says_so():
    turned, limits = (0.8, 0.6, 0.0, 0.0), {"one_joint": Limits(None, 2.0)}
    for saved, expected in (([turned], [("W-ZERO", "one_joint")]), (None, [])):
        log = Diagnostics()
        (dof,) = zeroed(robot_with([joint("ball", "base", "one", saved, limits=limits)]), log).dofs
        assert (dof.limits, reports(log)) == (limits["one_joint"], expected)
        assert saved is None or dof.saved == turned


FILE = Path(__file__).parent / "golden" / "own_terms.yaml"
GOLDEN = yaml.safe_load(FILE.read_text(encoding="utf-8"))
"""Title → keys of the configuration, and the elements that they come to."""

OWN = {"zero", "invert", "rotor_inertia", "gear"}


def made(keys):
    """A pinion that drives a rack, and a flap with a screw whose mass is estimated."""
    kit = Kit()
    base, wheel, rack, flap = kit.based("Wheel", "Rack", "Flap")
    pinion = kit.root.revolute("Pinion", (wheel, frame()), (base, frame((0, 0, 0.1))), 0.2, limits=(-1, 2))
    rail = kit.root.slider("Rail", (rack, frame()), (base, frame((0.1, 0, 0))), 0.02, limits=(0, 0.1))
    kit.root.rack("Gearing", pinion, rail, 0.6283185307179586, reverse=True)
    kit.root.revolute("Lid", (flap, frame()), (base, frame((0, 0.1, 0))), limits=(-0.5, 0.5))
    screw = kit.root.add(kit.studio.part("Screw", solids.box(0.002, 0.002, 0.002)))
    kit.root.fasten("Screwed", (screw, frame()), (flap, frame((0, 0, 0.05))))
    return exported(robot_of(kit.document, plan_of(**keys)), **keys)


def elements(outcome):
    """The joints of both files and what follows, and the masses, one a line."""
    mjcf, urdf = (etree.fromstring(outcome.files[f"robot.{end}"]) for end in ("xml", "urdf"))
    joints = (e for e in mjcf.iter("joint") if e.get("name") or e.getparent().tag == "equality")
    keys = (key for key in mjcf.iter("key") if key.get("name") not in ("home", "cad"))
    lines = [_line(element) for element in (*joints, *keys)]
    for element in urdf.iterfind("joint"):
        parts = [_line(part) for part in element if part.tag in ("axis", "limit", "mimic")]
        lines.append(f"urdf {element.get('name')}: {'; '.join(parts)}")
    return [*lines, f"mass {sum(float(mass.get('value')) for mass in urdf.iter('mass')):.9g}"]


def _line(element):
    return " ".join([element.tag, *(f"{key}={value}" for key, value in element.items())])


@pytest.mark.parametrize("title", GOLDEN)
def test_each_key_comes_to_its_golden_and_compiles(title):
    outcome = made(GOLDEN[title]["keys"])
    assert elements(outcome) == GOLDEN[title]["elements"], (
        "if this is meant: python -m tests.unit.graph.passes.test_own_terms"
    )
    model = compiled(outcome)
    for name in ("pinion", "rail", "lid"):
        # At its own zero a joint is where the untouched robot has that value of the mate.
        own = GOLDEN[title]["keys"].get("joints", {}).get(name, {})
        assert model.joint(name).range[0] < model.joint(name).range[1]
        if "armature" in own or "rotor_inertia" in own:
            expected = own["rotor_inertia"] * own.get("gear", 1) ** 2
            assert model.dof_armature[model.joint(name).dofadr[0]] == pytest.approx(expected)


def test_every_key_has_a_golden():
    entries = [entry["keys"] for entry in GOLDEN.values()]
    keys = {key for entry in entries for values in entry.get("joints", {}).values() for key in values}
    assert set(JointSection.model_fields) >= keys >= OWN
    assert any("total" in entry.get("mass", {}) for entry in entries)


if __name__ == "__main__":
    written = {
        title: {"keys": entry["keys"], "elements": elements(made(entry["keys"]))}
        for title, entry in GOLDEN.items()
    }
    FILE.write_text(yaml.safe_dump(written, sort_keys=False, width=200), encoding="utf-8")
