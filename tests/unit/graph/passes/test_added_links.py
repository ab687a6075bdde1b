"""Links and frames that CAD does not have, and the masses that links are given."""

import math
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.graph.passes.added_links import with_added_frames, with_added_links
from linkwright.stages.graph.passes.link_mass import check_links, with_given_masses
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import ZERO, primitive_inertial
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.model.poses import from_parts, inverse, rotation_from_rpy
from linkwright.stages.robot.model.robot import Frame, Inertial, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.support.building import plan_of
from tests.support.reported import only
from tests.support.reported import reports as problems
from tests.support.robots import at, joint, pose, robot_with

RNG = np.random.default_rng(7)
SPOT = pose(RNG)
STAND = pose(RNG)


def arm(**more):
    frames = [Frame("spot", "arm", frozen(SPOT), "Spot")]
    return robot_with([joint("revolute", "base", "arm", [0.2], place=pose(RNG))], frames=frames, **more)


def added(robot, **links):
    log = Diagnostics()
    return with_added_links(robot, plan_of(links=links).links, log), log


def framed(robot, **frames):
    log = Diagnostics()
    return with_added_frames(robot, plan_of(frames={"add": frames}).frames.add, log), log


PLACE = {"xyz": [0.1, 0.2, 0.3], "rpy": [0.3, -0.2, 1.1]}
OFFSET = from_parts(rotation_from_rpy((0.3, -0.2, 1.1)), np.array([0.1, 0.2, 0.3]))


def test_a_payload_hangs_on_its_parent_and_weighs():
    sphere = {"sphere": {"radius": 0.03}}
    robot, log = added(arm(), payload={"parent": "arm", **PLACE, "mass": 0.2, "geometry": sphere})
    link, hung = robot.links[-1], robot.joints[-1]
    assert (link.name, link.parts, link.path) == ("payload", (), ())
    assert (hung.name, hung.type, hung.parent, hung.child) == ("payload_joint", "fixed", "arm", "payload")
    assert (hung.dofs, hung.mate) == ((), None)
    np.testing.assert_allclose(hung.parent_from_joint, OFFSET, atol=1e-15)
    assert link.given is link.inertial
    np.testing.assert_allclose(link.inertial.inertia, 2 / 5 * 0.2 * 0.03**2 * np.eye(3), rtol=1e-12)
    assert [(shape.kind, shape.size) for shape in link.shapes] == [("sphere", (0.03,))]
    check_links(robot, log)
    assert problems(log) == []


@pytest.mark.parametrize(
    ("kind", "keys", "size"),
    [
        ("box", {"size": [0.1, 0.2, 0.3]}, (0.1, 0.2, 0.3)),
        ("cylinder", {"radius": 0.1, "length": 0.4}, (0.1, 0.4)),
        ("capsule", {"radius": 0.1, "length": 0.4}, (0.1, 0.4)),
    ],
)
def test_every_geometry_is_a_shape_and_an_inertia(kind, keys, size):
    """But an inertia of the user's goes before that of the geometry."""
    load = {"parent": "arm", "mass": 2, "com": [0, 0, 1], "geometry": {kind: keys}}
    link = added(arm(), load=load)[0].links[-1]
    assert (link.shapes[0].kind, link.shapes[0].size) == (kind, size)
    np.testing.assert_array_equal(link.inertial.com, [0, 0, 1])
    np.testing.assert_array_equal(link.inertial.inertia, primitive_inertial(kind, size, 2).inertia)
    link = added(arm(), load={**load, "inertia": [1, 1, 1]})[0].links[-1]
    np.testing.assert_array_equal(link.inertial.inertia, np.eye(3))


def test_a_link_may_hang_on_a_frame_or_an_added_link():
    first, second = {"parent": "spot", **PLACE}, {"parent": "zwei", "xyz": [0, 0, 1]}
    robot, log = added(arm(), eins=second, zwei=first)
    other, _ = added(arm(), zwei=first, eins=second)
    assert problems(log) == []
    assert [link.name for link in robot.links] == ["base", "arm", "zwei", "eins"]
    assert [link.name for link in other.links] == [link.name for link in robot.links]
    poses = link_poses(robot, {"arm_joint": 0.7})
    np.testing.assert_allclose(poses["eins"], poses["arm"] @ SPOT @ OFFSET @ at(0, 0, 1), atol=1e-14)


@pytest.mark.parametrize(
    ("keys_of_joint", "kind", "limits"),
    [
        ("revolute", "turn", (None, None)),
        ("continuous", "turn", (None, None)),
        ({"type": "revolute", "axis": [0, 3, 0], "limits": [-1, 1]}, "turn", (-1, 1)),
        ({"type": "prismatic", "axis": [0, 3, 0], "limits": [0, None]}, "slide", (0, None)),
    ],
)
def test_an_added_joint_moves_its_link_about_its_axis(keys_of_joint, kind, limits):
    keys = {"parent": "arm", "mass": 1, "inertia": [1, 1, 1], "joint": keys_of_joint, **PLACE}
    robot, log = added(arm(), wheel=keys)
    (dof,) = robot.joints[-1].dofs
    assert (dof.name, dof.kind, dof.saved) == ("wheel_joint", kind, 0.0)
    assert (dof.limits.lower, dof.limits.upper) == limits
    assert np.linalg.norm(dof.axis) == 1
    poses = link_poses(robot, {"wheel_joint": 0.5})
    local = inverse(poses["arm"] @ OFFSET) @ poses["wheel"]
    if kind == "slide":
        np.testing.assert_allclose(local, at(0, 0.5, 0), atol=1e-14)
    else:
        assert math.acos((np.trace(local[:3, :3]) - 1) / 2) == pytest.approx(0.5)
        np.testing.assert_allclose(local[:3, :3] @ dof.axis, dof.axis, atol=1e-14)
    assert problems(log) == []


def test_a_moving_link_without_mass_is_reported():
    robot, log = added(arm(), wheel={"parent": "arm", "joint": "revolute"})
    check_links(robot, log)
    assert problems(log) == [("E-MASS", "wheel")]


def stays(before, robot, q):
    """Whether all links are where they were."""
    old, new = link_poses(before, q), link_poses(robot, q)
    for name in old:
        np.testing.assert_allclose(robot.world_from_root @ new[name], STAND @ old[name], atol=1e-14)


def test_a_link_above_the_root_leaves_everything_where_it_is():
    before = arm(world_from_root=STAND)
    robot, log = added(before, base_footprint={"child": "base", **PLACE})
    assert problems(log) == []
    assert [link.name for link in robot.links] == ["base_footprint", "base", "arm"]
    assert [joint.child for joint in robot.joints] == ["base", "arm"]
    assert robot.base is before.base
    stays(before, robot, {"arm_joint": 0.4})
    np.testing.assert_allclose(link_poses(robot)["base"], OFFSET, atol=1e-15)


def test_a_floating_link_floats_from_the_new_root():
    there = (0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.0)
    crate = joint("free", "base", "crate", [there], place=OFFSET)
    before = robot_with([*arm(world_from_root=STAND).joints, crate], world_from_root=STAND)
    robot, log = added(before, foot={"child": "base", **PLACE}, ground={"child": "foot", **PLACE})
    assert problems(log) == []
    assert robot.joints[-1].parent == robot.root.name == "ground"
    stays(before, robot, {"crate_joint": there, "arm_joint": 0.4})


@pytest.mark.parametrize(
    ("links", "name", "text"),
    [
        ({"load": {"parent": "leg"}}, "load", "its parent 'leg' is not a link or frame"),
        ({"load": {"child": "arm"}}, "load", "'arm' is not the root"),
        ({"a": {"child": "base"}, "b": {"child": "base"}}, "b", "'base' is not the root"),
        ({"a": {"parent": "b"}, "b": {"parent": "a"}}, "a", "its parent 'b' is not a link or frame"),
        ({"arm": {"parent": "base"}}, "arm", "the name 'arm' is taken"),
        ({"spot": {"parent": "base"}}, "spot", "the name 'spot' is taken"),
        ({"a b": {"parent": "base"}}, "a b", "invalid name 'a b'"),
        ({"world": {"parent": "base"}}, "world", "reserved"),
        ({"a": {"parent": "base", "joint": {"name": "arm_joint"}}}, "a", "the name 'arm_joint' is taken"),
        ({"a": {"parent": "base", "joint": {"name": "a"}}}, "a", "the name 'a' is taken"),
    ],
)
def test_a_link_that_cannot_be_is_reported(links, name, text):
    _, log = added(arm(), **links)
    assert f"links.{name}" in [problem.where for problem in log.problems]
    assert text in " ".join(problem.message for problem in log.problems)


def test_a_link_cannot_go_above_the_assemblys_origin():
    robot = robot_with([joint("revolute", "world", "arm")], root="world")
    _, log = added(robot, foot={"child": "world"})
    assert problems(log) == [("E-LINK", "links.foot")]


def test_a_joint_that_is_not_named_takes_a_name_that_is_free():
    robot, log = added(arm(), load={"parent": "arm"}, load_joint={"parent": "arm"})
    assert problems(log) == []
    assert [joint.name for joint in robot.joints[1:]] == ["load_joint_2", "load_joint_joint"]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({}, "must have a parent or a child"),
        ({"parent": "a", "child": "b"}, "must have a parent or a child"),
        ({"child": "b", "joint": "revolute"}, "must have a fixed joint"),
        ({"parent": "a", "mass": 1}, "must have a geometry or an inertia"),
        ({"parent": "a", "com": [0, 0, 0]}, "must have a mass"),
        ({"parent": "a", "joint": "screw"}, "'screw' is not allowed"),
        ({"parent": "a", "joint": {"type": "continuous", "limits": [0, 1]}}, "must have no limits"),
        ({"parent": "a", "joint": {"type": "revolute", "axis": [0, 0, 0]}}, "must not be zero"),
        ({"parent": "a", "geometry": {}}, "must be one of sphere, box, cylinder, capsule"),
        ({"parent": "a", "geometry": {"sphere": {"radius": 0}}}, "greater than 0"),
        ({"parent": "a", "geometry": {"cone": {}}}, "unknown key"),
    ],
)
def test_keys_that_contradict_each_other_are_refused(keys, message):
    with pytest.raises(ConfigError) as caught:
        plan_of(links={"load": keys})
    assert message in str(caught.value)


def test_an_added_frame_is_where_it_is_said_to_be():
    robot, log = framed(arm(), tool={"link": "spot", **PLACE}, eye={"link": "tool"}, foot={"link": "base"})
    assert problems(log) == []
    assert [frame.name for frame in robot.frames] == ["eye", "foot", "spot", "tool"]
    frames = {frame.name: frame for frame in robot.frames}
    for name in ("eye", "tool"):
        assert (frames[name].link, frames[name].source) == ("arm", "")
        np.testing.assert_allclose(frames[name].link_from_frame, SPOT @ OFFSET, atol=1e-15)


@pytest.mark.parametrize(
    ("frames", "problem"),
    [
        ({"tool": {"link": "leg"}}, ("E-FRAME", "frames.add.tool")),
        ({"arm": {"link": "base"}}, ("E-NAME", "frames.add.arm")),
        ({"spot": {"link": "base"}}, ("E-NAME", "frames.add.spot")),
        ({"arm_joint": {"link": "base"}}, ("E-NAME", "frames.add.arm_joint")),
    ],
)
def test_a_frame_that_cannot_be_is_reported(frames, problem):
    assert problems(framed(arm(), **frames)[1]) == [problem]


def with_masses(robot, **links):
    log = Diagnostics()
    return with_given_masses(robot, plan_of(mass={"links": links}).mass.links, log), log


def hinged(**more):
    return robot_with([joint("revolute", "base", "arm", [0.2])], **more)


def test_a_links_mass_scales_the_sum_of_its_parts():
    robot = hinged()
    before = robot.link("arm").inertial
    made, log = with_masses(robot, **{"a*": {"mass": 2 * before.mass}})
    link = made.link("arm")
    assert problems(log) == []
    assert link.inertial is link.given
    np.testing.assert_array_equal(link.inertial.com, before.com)
    np.testing.assert_allclose(link.inertial.inertia, 2 * before.inertia, rtol=1e-15)
    assert made.link("base") is robot.link("base")


def test_a_links_com_and_inertia_are_taken_as_given():
    robot = hinged()
    made, _ = with_masses(robot, arm={"com": [1, 2, 3]}, **{"*m": {"inertia": [1, 1, 1.5]}})
    inertial = made.link("arm").inertial
    assert (inertial.mass, *inertial.com) == (robot.link("arm").inertial.mass, 1, 2, 3)
    np.testing.assert_array_equal(inertial.inertia, np.diag([1, 1, 1.5]))
    _, log = with_masses(hinged(inertials={"arm": ZERO}), arm={"mass": 1})
    assert (only(log).code, only(log).where) == ("E-MASS", "arm")
    assert "com and inertia must be given" in only(log).message
    made, log = with_masses(
        hinged(inertials={"arm": ZERO}), arm={"mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1]}
    )
    assert problems(log) == checked_links(made) == []


@pytest.mark.parametrize(
    ("massless", "fixed", "lacking"),
    [
        ({"base"}, True, []), ({"base"}, False, ["base"]), ({"arm"}, True, []),
        ({"arm", "tip"}, True, ["arm"]), ({"tip"}, True, []), ({"arm", "tip"}, False, ["arm"]),
    ],
)  # fmt: skip
def test_links_that_move_as_a_whole_need_mass(massless, fixed, lacking):
    joints = [joint("revolute", "base", "arm"), joint("fixed", "arm", "tip")]
    robot = robot_with(joints, fixed=fixed, inertials=dict.fromkeys(massless, ZERO))
    assert checked_links(robot) == [("E-MASS", name) for name in lacking]


NEEDLE = np.diag([1e-3, 1e-6, 1e-6])


def checked_links(robot):
    log = Diagnostics()
    check_links(robot, log)
    return problems(log)


def test_an_inertia_that_no_solid_can_have_names_the_link():
    assert checked_links(hinged(inertials={"arm": Inertial(1.0, frozen([0, 0, 0]), frozen(NEEDLE))})) == [
        ("E-INERTIA", "arm")
    ]


def test_an_impossible_part_is_reported_once_for_its_kind():
    robot = hinged()
    link = robot.link("arm")
    bad = Inertial(1e-6, frozen([0, 0, 0]), frozen(1e-6 * NEEDLE))
    rest = tuple(
        replace(
            link.parts[0], name=f"wire <{n}>", inertial=bad, link_from_part=pose(np.random.default_rng(n))
        )
        for n in (1, 2)
    )
    robot = replace(robot, links=(robot.links[0], replace(link, parts=(*link.parts, *rest))))
    assert checked_links(robot) == [("W-INERTIA", "wire <1>")]
    assert checked_links(with_masses(robot, arm={"mass": 1})[0]) == []


def test_a_glob_of_masses_without_a_match_lists_the_links():
    problem = only(with_masses(hinged(), leg={"mass": 1})[1])
    assert (problem.code, problem.hint) == ("E-GLOB", "links are: arm, base")
