"""Contact of a robot with itself: which pairs of links do not collide, and what is reported."""

import math
import re
from dataclasses import replace
from itertools import combinations

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.errors import ConfigError
from linkwright.stages.mesh.contacts import analysis
from linkwright.stages.mesh.contacts.by_source import excluded_by_source
from linkwright.stages.mesh.contacts.colliders import Colliders, measures_overlaps
from linkwright.stages.mesh.contacts.excluded_pairs import excluded_pairs
from linkwright.stages.robot import codec
from linkwright.stages.robot.errors import MeshError
from linkwright.stages.robot.model.geometry import Exclude, Shape
from linkwright.stages.robot.model.poses import turn
from linkwright.stages.robot.model.robot import Limits, Primitive, Relation
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.start_pose import home, saved
from tests.support import mjcfs
from tests.support.building import plan_of, write
from tests.support.exports import compiled, exported
from tests.support.robots import EVERY, at, joint, loop, robot_with
from tests.support.touching import Memory, apart, ball, box, geometry_of, geoms_in_mujoco, in_mujoco
from tests.unit.robot.test_home import four_bar

OFF = at(0.007, 0.004, 0.07)
"""Old versions of MuJoCo see no contact of boxes with one middle, or where one pierces the other."""

GEARS = [Relation("gear", "right_joint", "left_joint", 1.0, 0.0)]


def reasons(geometry):
    return {(exclude.link_a, exclude.link_b): exclude.reason for exclude in geometry.excludes}


def with_reason(geometry, reason):
    (exclude,) = [exclude for exclude in geometry.excludes if exclude.reason == reason]
    return exclude


def close(depth, tolerance=1e-6):
    """The depth, as far as this MuJoCo measures it."""
    return pytest.approx(depth, abs=tolerance if measures_overlaps() else 0.6 * depth)


def said(geometry, code):
    return [diagnostic for diagnostic in geometry.diagnostics if diagnostic.code == code]


def base_arm_hand(**shapes):
    """A fixed base, an arm that turns on it about z, and a hand that turns about the arm's axis too."""
    joints = [
        joint("revolute", above, link, place=place, limits={f"{link}_joint": Limits(-3.0, 3.0)})
        for above, link, place in (("base", "arm", np.eye(4)), ("arm", "hand", at(0, 0, 0.1)))
    ]
    shapes = {"base": box(0.2, 0.2, 0.1), "arm": box(0.05, 0.05, 0.2, OFF), "hand": ball(0.05), **shapes}
    return robot_with(joints, shapes={name: (shape,) for name, shape in shapes.items() if shape})


def one_exclude(robot, pair):
    """The geometry of a robot whose only exclude is this adjacent pair, which touches without it."""
    geometry = geometry_of(robot)
    assert reasons(geometry) == {pair: "Adjacent"}
    assert touching(robot, geometry) == set()
    assert touching(robot, replace(geometry, excludes=())) == {pair}
    return geometry


def touching(robot, geometry, q=None):
    return in_mujoco(compiled(exported(robot, geometry)), robot, home(robot) if q is None else q)


def test_base_that_overlaps_its_child_is_excluded_as_adjacent():
    """By 93 mm in the sample, by 80 mm here. A root called `world` is the world."""
    robot = base_arm_hand(hand=None)
    geometry = one_exclude(robot, ("base", "arm"))
    assert geometry.self_contact
    assert geometry.excludes[0].depth == close(-apart(robot, home(robot))["base", "arm"])
    bare = robot_with([joint("revolute", "world", "arm", place=OFF)], root="world")
    on_world = replace(bare, links=tuple(replace(link, shapes=(ball(0.1),)) for link in bare.links))
    one_exclude(on_world, ("world", "arm"))


def test_faces_on_each_other_touch_and_faces_apart_do_not():
    on_it = geometry_of(base_arm_hand(hand=ball(0.05)))
    assert with_reason(on_it, "Always").depth == pytest.approx(0.0, abs=1e-6)
    for keys in (
        {},
        {"exclude": [["arm", "*"]]},
    ):  # the reason is the joint where the user names the pair too
        beside = geometry_of(base_arm_hand(hand=ball(0.049)), **keys)
        assert reasons(beside) == dict.fromkeys([("base", "arm"), ("arm", "hand")], "Adjacent")
        assert not [diagnostic for diagnostic in beside.diagnostics if "CONTACT" in diagnostic.code]
    shapes = {"base": (box(0.2, 0.2, 0.1),), "arm": (box(0.05, 0.05, 0.2),)}  # with the same middle
    (exclude,) = geometry_of(robot_with([joint("revolute", "base", "arm")], shapes=shapes)).excludes
    assert exclude.depth == close(0.125, 1e-4)


def test_pair_that_always_touches_is_excluded_with_its_depth():
    geometry = geometry_of(base_arm_hand(hand=ball(0.06)))
    always = with_reason(geometry, "Always")
    assert (always.link_a, always.link_b, always.depth) == ("base", "hand", pytest.approx(0.01, abs=1e-6))
    (diagnostic,) = said(geometry, "I-ALWAYS-CONTACT")
    assert "base and hand (10.00 mm deep)" in diagnostic.message
    assert not said(geometry, "W-SELF-CONTACT")
    assert geometry_of(robot_with([joint("revolute", "base", "one")])).excludes == ()


def fingers(saved):
    """The joints of two fingers that slide towards each other on a palm, saved there."""
    joints = []
    for name, sign in (("left", 1), ("right", -1)):
        place = at(0.06 * sign, 0, 0)
        place[:3, :3] = turn(np.array([0.0, 1.0, 0.0]), math.copysign(math.pi / 2, sign))
        limits = {f"{name}_joint": Limits(-0.06, 0.0)}
        joints.append(joint("prismatic", "palm", name, place=place, limits=limits, saved=[saved]))
    return joints


def test_fingers_that_touch_at_home_stay_and_the_yaml_is_shown():
    finger = (box(0.01, 0.01, 0.01),)
    shapes = {"palm": (box(0.01, 0.2, 0.01, at(0, 0.2, 0)),), "left": finger, "right": finger}
    robot = robot_with(fingers(-0.058), shapes=shapes, root="palm", relations=GEARS)
    geometry = geometry_of(robot)
    assert ("left", "right") not in reasons(geometry)
    (diagnostic,) = said(geometry, "W-SELF-CONTACT")
    assert "left and right (6.00 mm deep)" in diagnostic.message or not measures_overlaps()
    assert "`contact: {exclude: [[left, right]]}`" in diagnostic.hint
    assert touching(robot, geometry) == {("left", "right")}
    settled = geometry_of(robot, exclude=[["left", "right"]])
    assert reasons(settled)["left", "right"] == "User"
    assert not said(settled, "W-SELF-CONTACT")
    assert touching(robot, settled) == set()


def gripper(at_home=0.0):
    """Two fingers that slide towards each other, with racks that always overlap, and pads that meet."""
    rack, pad = box(0.01, 0.01, 0.3), box(0.01, 0.01, 0.01, at(0, 0.1, 0))
    shapes = {"palm": (box(0.01, 0.2, 0.01, at(0, 0.5, 0)),), "left": (rack, pad), "right": (rack, pad)}
    return robot_with(fingers(at_home), shapes=shapes, root="palm", relations=GEARS)


def test_pads_of_fingers_whose_racks_always_overlap_still_meet():
    robot = gripper()
    geometry = geometry_of(robot)
    always = with_reason(geometry, "Always")
    assert (always.link_a, always.link_b, always.geoms) == ("left", "right", ((0, 0),))
    (diagnostic,) = said(geometry, "I-ALWAYS-CONTACT")
    assert diagnostic.message.endswith("mm deep), but only box 0 against box 0")
    assert geometry.touching == ()
    model = compiled(exported(robot, geometry))
    for q, met in ((-0.03, set()), (-0.0549, set()), (-0.0551, {(("left", 1), ("right", 1))})):
        assert geoms_in_mujoco(model, robot, {"left_joint": q, "right_joint": q}) == met


def test_pads_that_touch_at_home_are_reported_till_excluded():
    robot = gripper(-0.058)
    geometry = geometry_of(robot)
    assert reasons(geometry)["left", "right"] == "Always"
    (pair,) = geometry.touching
    assert (pair.link_a, pair.link_b, pair.depth) == ("left", "right", close(0.006))
    assert "left and right (6.00 mm deep)" in said(geometry, "W-SELF-CONTACT")[0].message
    settled = geometry_of(robot, exclude=[["left", "right"]])
    assert (with_reason(settled, "User").geoms, settled.touching) == ((), ())
    assert touching(robot, settled) == set()


def test_poses_satisfy_relations():
    joints = [
        joint("prismatic", "palm", name, limits={f"{name}_joint": Limits(-0.1, 0.1)})
        for name in ("left", "right")
    ]
    shapes = {"left": (ball(0.01),), "right": (ball(0.01, at(0.015, 0, 0)),)}
    shapes["palm"] = (ball(0.01, at(0, 1, 0)),)
    bare = robot_with(joints, shapes=shapes, root="palm")
    assert "Always" not in reasons(geometry_of(bare)).values()
    assert reasons(geometry_of(replace(bare, relations=tuple(GEARS))))["left", "right"] == "Always"


def test_poses_close_loops():
    """The end of the coupler stays near its place as long as the rocker holds it."""
    four = four_bar({"drive": Limits(1.0, 1.2)})
    end = (link_poses(four, home(four))["coupler"] @ at(0.13, 0, 0))[:3, 3]
    shapes = {
        "base": (box(0.06, 0.06, 0.06, at(*end)),),
        "coupler": (ball(0.01, at(0.13, 0, 0)),),
        "crank": (ball(0.01, at(0, 0, 1)),),
        "rocker": (ball(0.01, at(0, 0, 2)),),
    }
    robot = replace(four, links=tuple(replace(link, shapes=shapes[link.name]) for link in four.links))
    assert reasons(geometry_of(robot))["base", "coupler"] == "Always"
    assert ("base", "coupler") not in reasons(geometry_of(replace(robot, loops=())))


@pytest.mark.parametrize(("upper", "always"), [(0.009, True), (0.05, False)])
def test_poses_stay_within_limits(upper, always):
    shapes = {"base": box(0.1, 0.1, 0.1), "one": box(0.01, 0.01, 0.01), "two": ball(0.02, at(0, 0, 0.06))}
    joints = [joint("revolute", "base", "one")]
    joints += [joint("prismatic", "one", "two", limits={"two_joint": Limits(-0.005, upper)})]
    robot = robot_with(joints, shapes={name: (shape,) for name, shape in shapes.items()})
    assert (reasons(geometry_of(robot)).get(("base", "two")) == "Always") is always


def test_all_lets_everything_collide_but_what_the_user_names():
    robot = base_arm_hand(hand=ball(0.06))
    geometry = geometry_of(robot, self="all", exclude=[["ha*", "base"]])
    assert reasons(geometry) == {("base", "hand"): "User"}
    assert not said(geometry, "W-SELF-CONTACT")
    assert ("base", "arm") in {(pair.link_a, pair.link_b) for pair in geometry.touching}
    assert touching(robot, geometry) == {("base", "arm")}


def test_none_lets_no_links_collide():
    robot = base_arm_hand(hand=ball(0.06))
    geometry = geometry_of(robot, self="none")
    assert (geometry.self_contact, geometry.excludes) == (False, ())
    assert not [diagnostic for diagnostic in geometry.diagnostics if "CONTACT" in diagnostic.code]
    assert touching(robot, geometry) == set()
    text = exported(robot, geometry).files["robot.xml"].decode()
    assert 'contype="1" conaffinity="2"' in text
    assert "<contact" not in text


@pytest.mark.parametrize("on", ["auto", "none", "all"])
def test_ground_and_objects_collide_whatever_contact_self_is(on, tmp_path):
    robot = base_arm_hand(hand=ball(0.3))
    write(robot, tmp_path, geometry=geometry_of(robot, self=on))
    file = tmp_path / "robot.xml"
    file.write_text(re.sub(r"<keyframe>.*</keyframe>", "", file.read_text(), flags=re.DOTALL))
    spec = mujoco.MjSpec.from_file(str(tmp_path / "scene.xml"))
    thing = spec.worldbody.add_body(name="thing", pos=[0, 0, 0.4])
    thing.add_freejoint()
    thing.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.05, 0, 0])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    bodies = {
        frozenset(model.body(model.geom_bodyid[geom]).name for geom in contact.geom)
        for contact in data.contact[: data.ncon]
    }
    assert {frozenset({"world", "hand"}), frozenset({"thing", "hand"})} <= bodies


@pytest.mark.parametrize("self", ["auto", "all", "none"])
def test_globs_that_match_nothing_are_errors_that_list_the_links(self):
    with pytest.raises(MeshError) as caught:
        geometry_of(base_arm_hand(), self=self, exclude=[["arm", "leg*"], ["fo?t", "ar*"], ["hand", "h*"]])
    assert [problem.message for problem in caught.value.problems] == [
        "no link matches 'leg*'",
        "no link matches 'fo?t'",
        "'hand' and 'h*' match the same link, which cannot touch itself",
    ]
    assert {problem.hint for problem in caught.value.problems} == {"links are: arm, base, hand"}


@pytest.mark.parametrize("wrong", [[["a"]], [["a", "b", "c"]], ["ab"], [["a", 1]], [["", "b"]]])
def test_values_that_are_no_pair_of_globs_are_refused(wrong):
    with pytest.raises(ConfigError, match=r"contact\.exclude"):
        plan_of(contact={"exclude": wrong})


@pytest.mark.parametrize("fixed", [True, False])
@pytest.mark.parametrize("kind", EVERY)
def test_no_type_of_joint_lets_its_links_collide(kind, fixed):
    root = "world" if kind == "free" else "base"
    joints = [joint(kind, root, "one"), joint("revolute", "one", "two")]
    shapes = {name: (ball(0.05),) for name in ("base", "one", "two") if name != root or kind != "free"}
    robot = robot_with(joints, shapes=shapes, fixed=fixed or kind == "free", root=root)
    geometry = geometry_of(robot)
    left_out = set(reasons(geometry))
    overlapping = {pair for pair, distance in apart(robot, home(robot)).items() if distance < 0}
    assert touching(robot, geometry) == overlapping - left_out
    assert {(row.parent, row.child) for row in joints if row.type != "free"} <= left_out


@pytest.mark.parametrize("kind", [kind for kind in EVERY if kind != "free"])
def test_no_type_of_loop_lets_its_links_collide(kind):
    joints = [joint("revolute", "base", "one"), joint("revolute", "base", "two")]
    shapes = {name: (ball(0.05, at(0.2, 0, 0)),) for name in ("one", "two")}
    robot = robot_with(joints, loops=[loop(kind, "one", "two", np.eye(4), np.eye(4))], shapes=shapes)
    geometry = geometry_of(robot)
    assert reasons(geometry) == {("one", "two"): "Adjacent"}
    assert touching(robot, geometry, saved(robot)) == set()
    assert touching(robot, replace(geometry, excludes=()), saved(robot)) == {("one", "two")}


def test_excludes_do_not_depend_on_the_order_of_links():
    def excludes(names):
        joints = [joint("revolute", "base", name, place=at(0, 0, 0.1)) for name in names]
        shapes = {"base": (ball(0.02),), **{name: (ball(0.03, at(0, 0.0, 0)),) for name in names}}
        geometry = geometry_of(robot_with(joints, shapes=shapes))
        return {(frozenset((row.link_a, row.link_b)), row.reason, row.depth) for row in geometry.excludes}

    assert excludes("abc") == excludes("cab")
    assert [reason for _, reason, _ in excludes("abc")].count("Always") == 3


def test_work_is_repeated_where_motion_or_a_collider_changes():
    memo, robot = Memory(), base_arm_hand()
    heavier = tuple(replace(link, inertial=replace(link.inertial, mass=5.0)) for link in robot.links)
    arm, hand = robot.joints
    bent = replace(hand, dofs=(replace(hand.dofs[0], limits=Limits(0.0, 1.0)),))
    for other in (robot, replace(robot, links=heavier), base_arm_hand(hand=ball(0.06))):
        geometry_of(other, memo)
    geometry_of(robot, memo, self="all")
    geometry_of(robot, memo, exclude=[["base", "hand"]])
    geometry_of(replace(robot, joints=(arm, bent)), memo)
    keys = memo.keys_of("mesh.contacts")
    assert keys[0] == keys[1]
    assert len(set(keys)) == 5


def test_geometry_travels_with_its_excludes():
    for robot in (base_arm_hand(hand=ball(0.06)), gripper()):
        geometry = geometry_of(robot)
        again = codec.decode_geometry(codec.encode_geometry(geometry))
        assert (again.excludes, again.self_contact) == (geometry.excludes, True)
    assert Exclude("base", "hand", "Always", 0.01) in geometry_of(base_arm_hand(hand=ball(0.06))).excludes


def test_single_pose_apart_is_enough_to_keep_a_pair(monkeypatch):
    touched = []

    def touch(self, pair):
        touched.append(pair)
        return np.array([[len(touched) != analysis.POSES]])

    monkeypatch.setattr(Colliders, "touching", touch)
    geometry = geometry_of(base_arm_hand(hand=ball(0.06)))
    assert len(touched) == analysis.POSES
    assert ("base", "hand") not in reasons(geometry)


def test_links_whose_boxes_meet_are_those_of_all_pairs():
    rng = np.random.default_rng(5)
    names = [f"link_{number}" for number in range(40)]
    pairs = [(box(*size), ball(size[0], at(*size))) for size in rng.uniform(0.02, 0.2, (40, 3))]
    shapes = [
        Shape(name, "collision", None, None, 0, 0, 0.0, 0.0, primitive)
        for name, pair in zip(names, pairs, strict=True)
        for primitive in pair
    ]
    colliders = Colliders(shapes, {})
    for name, place in zip(names, rng.uniform(0, 0.8, (40, 3)), strict=True):
        colliders.place(name, at(*place))
    combined = [*combinations(names, 2)]
    met = colliders.meeting(names)
    assert met == sorted(met, key=combined.index)
    assert 0 < len(met) < len(combined)
    assert colliders.depths(met).keys() == colliders.depths(combined).keys()
    assert colliders.meeting([]) == []


def test_pairs_that_are_compared_grow_with_the_links(monkeypatch):
    compared = set()
    monkeypatch.setattr(Colliders, "_depths", lambda self, pair, *_: compared.add(pair) or np.zeros((1, 1)))
    for count in (25, 100):
        compared.clear()
        names = [f"link_{number}" for number in range(count)]
        joints = [joint("revolute", "base", name, place=at(x, 0, 0)) for x, name in enumerate(names)]
        geometry_of(robot_with(joints, shapes={name: (box(1.2, 0.6, 0.6),) for name in names}))
        assert len(compared) == count - 1


def test_exclude_of_a_body_with_itself_is_no_pair_of_links(tmp_path):
    """MuJoCo compiles such an MJCF."""
    arm = mjcfs.body("arm", '<joint name="j"/><geom size=".1"/>', pos="0 0 .5")
    text = mjcfs.model(
        mjcfs.body("base", f'<geom size=".1"/>{arm}'),
        '<contact><exclude body1="base" body2="base"/><exclude body1="arm" body2="base"/></contact>',
    )
    robot = mjcfs.robot_of(mjcfs.written(tmp_path, text))
    assert excluded_by_source(robot) == {frozenset(("arm", "base"))}
    pairs = excluded_pairs(robot, ["base", "arm"], plan_of(contact={"self": "auto"}).contact, ())
    assert pairs >= {("arm", "base")}


def test_work_is_repeated_where_a_hull_becomes_an_ellipsoid():
    """Their file is the same, but MuJoCo collides the ellipsoid."""
    hull = Shape("arm", "collision", "arm.stl", None, 0, 0, 0.0, 0.0)
    egg = replace(hull, ellipsoid=Primitive("ellipsoid", (0.2, 0.2, 0.1), at(0.3)))
    hull_key, key, moved_key = (
        analysis._key_of_shape(shape, {"arm.stl": b""})
        for shape in (hull, egg, replace(egg, ellipsoid=replace(egg.ellipsoid, link_from_shape=OFF)))
    )
    assert hull_key != key != moved_key
