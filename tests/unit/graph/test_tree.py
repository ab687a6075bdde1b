"""Root, tree and cut, on mechanisms made by hand."""

import re
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.graph.mechanism import Connection, Marker, Mechanism, RelationSpec, RigidBody
from linkwright.stages.graph.onshape.mates.joints import JOINT_TYPES, dofs_of
from linkwright.stages.graph.robot_from_tree import place
from linkwright.stages.graph.root import choose_root
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.graph.tree import spanning_tree
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import Disconnected, NoRoot
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Inertial, MateRef, Part, Provenance, frozen
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from tests.support.reported import codes, reports

IDENTITY = frozen(np.eye(4))


def body(name, mass=1.0, held="", **more):
    inertial = Inertial(mass, frozen(np.zeros(3)), frozen(np.eye(3) * mass))
    part = Part((name,), f"{name} <1>", "p", None, IDENTITY, IDENTITY, inertial, 1.0)
    parts = () if name == "world" else (part,)
    return replace(RigidBody(name, (name,), parts, frozenset({name, f"{name} <1>"}), held, IDENTITY), **more)


def pose(seed):
    drawn = np.random.default_rng(seed)
    return frozen(from_parts(rotation_from_rpy(tuple(drawn.uniform(-3, 3, 3))), drawn.uniform(-1, 1, 3)))


def mate(name, first, second, kind="REVOLUTE", seed=1, limits=None):
    dofs, ref = dofs_of(name, kind, limits or {}, np.eye(4)), MateRef((), name, name.title(), kind)
    frames = (pose(seed), pose(seed))
    return Connection(name, JOINT_TYPES[kind], (first, second), frames, dofs, 0.0, ref, name.title())


def mechanism(bodies, connections, **more):
    made = Mechanism(tuple(bodies), tuple(connections), (), (), Provenance("", "", "", ""))
    return replace(made, **more)


def keys(**root):
    cut = root.pop("cut", ())
    return GraphSections.model_validate({"root": root, "loops": {"cut": cut}})


def tree_of(drawn, log=None, **root):
    return spanning_tree(drawn, keys(**root), log or Diagnostics())


CHAIN = mechanism(
    [body("a"), body("b", 5.0), body("c"), body("d")], [mate("ab", 0, 1), mate("bc", 1, 2), mate("cd", 2, 3)]
)


def test_auto_is_what_is_held_else_the_heaviest():
    assert tree_of(CHAIN).root == 1
    held = replace(CHAIN, bodies=(*CHAIN.bodies[:3], body("d", fixed_reason="d is fixed")))
    assert tree_of(held).root == 3


def test_central_is_the_nearest_to_all_whatever_is_held():
    bodies = [body("a", fixed_reason="fixed"), body("b"), body("c"), body("d", 9.0), body("e")]
    drawn = mechanism(bodies, [mate(f"m{i}", i, i + 1) for i in range(4)])
    assert tree_of(drawn, select="central").root == 2


def test_a_name_or_a_glob_selects_by_link_or_by_instance():
    assert tree_of(CHAIN, select="c").root == 2
    assert tree_of(CHAIN, select="d <*>").root == 3
    named = mechanism([body("a"), body("b", titles=frozenset({"Pump [x] <1>"}))], [])
    for text in ("Pump [x] <1>", "Pump [x]", "Pump*"):
        assert choose_root(named, keys(select=text).root)[0] == 1


TIPPED = replace(CHAIN, markers=(Marker("tip", "Arm/Tip", 2, pose(7), "Tip"),))


def test_a_frame_gives_the_root_its_link_and_its_pose():
    for text in ("tip", "Tip", "Arm/Tip"):
        tree = tree_of(TIPPED, frame=text)
        assert (tree.root, tree.world_from_root) == (2, TIPPED.markers[0].world_from_frame)
    stays(place(TIPPED, tree_of(TIPPED, frame="tip"), keys(frame="tip"), Diagnostics()))


@pytest.mark.parametrize(
    ("root", "message"),
    [
        ({"select": "x"}, "no links match 'x'"),
        ({"select": "*"}, "4 links match"),
        ({"frame": "tip", "select": "a"}, "on the link 'c', but the root is 'a'"),
        ({"frame": "hand"}, "no mate connectors are called 'hand'"),
    ],
)
def test_a_root_that_is_none_or_not_clear_is_refused(root, message):
    with pytest.raises(NoRoot, match=re.escape(message)):
        tree_of(TIPPED, **root)


def test_the_origin_is_the_root_where_links_move_against_it():
    drawn = mechanism([body("world", fixed_reason="origin"), body("a", 9.0)], [mate("rail", 1, 0, "SLIDER")])
    assert tree_of(drawn).root == 0
    with pytest.raises(NoRoot, match="'a' cannot be the root: Rail"):
        tree_of(drawn, select="a")
    log = Diagnostics()
    assert place(drawn, tree_of(drawn, base="free"), keys(base="free"), log).base.fixed
    assert codes(log) == ["E-BASE"]


def ring(*kinds, **limits):
    """A single loop of bodies b0, b1, ... with mates m0 (b0 to b1), m1, ..."""
    count, names = len(kinds), [f"m{i}" for i in range(len(kinds))]
    mates = [mate(n, i, (i + 1) % count, kinds[i], limits=limits.get(n)) for i, n in enumerate(names)]
    return mechanism([body(f"b{i}", 1.0 + (i == 0)) for i in range(count)], mates)


def cut(drawn, log=None, **root):
    return {connection.name for connection in tree_of(drawn, log, **root).cut}


@pytest.mark.parametrize(
    ("kinds", "name"),
    [
        ("REVOLUTE REVOLUTE REVOLUTE", "m2"),
        ("REVOLUTE SLIDER SLIDER", "m0"),
        ("SLIDER CYLINDRICAL SLIDER", "m1"),
        ("BALL REVOLUTE CYLINDRICAL SLIDER", "m0"),
        ("REVOLUTE REVOLUTE", "m1"),
    ],
)
def test_loops_of_any_size_are_cut_at_balls_and_hinges_first(kinds, name):
    assert cut(ring(*kinds.split())) == {name}


def test_limited_and_related_mates_stay_in_the_tree():
    limits = {"limitAxialZMin": -1.0, "limitAxialZMax": 1.0}
    drawn = ring("REVOLUTE", "REVOLUTE", "REVOLUTE", m1=limits, m2=limits)
    assert cut(drawn) == {"m0"}
    spec = RelationSpec("Gear", "GEAR", ("m0", "m1"), 1.0, 0.0, False)
    assert cut(replace(drawn, relations=(spec,))) == {"m2"}


def test_the_user_says_where_loops_are_cut():
    assert cut(ring("REVOLUTE", "SLIDER", "REVOLUTE"), cut=("M1",)) == {"m1"}
    log = Diagnostics()
    assert cut(CHAIN, log, cut=("ab", "m7")) == set()
    assert [code for code, _ in reports(log)] == ["E-GLOB", "W-LOOP-CUT"]
    assert log.problems[0].where == "loops.cut"


TORN = mechanism(
    [body("a", 3.0), body("b"), body("c", 2.0), body("d"), body("e")], [mate("ab", 0, 1), mate("cd", 2, 3)]
)


def test_loose_bodies_are_an_error_that_lists_the_ways_out():
    with pytest.raises(Disconnected) as caught:
        tree_of(TORN)
    assert [(p.code, p.where) for p in caught.value.problems] == [("E-LOOSE", "c <1>"), ("E-LOOSE", "e <1>")]
    assert "weld" in caught.value.hint
    assert "separate" in caught.value.hint


def stays(robot):
    """Whether the parts are where they were."""
    poses = link_poses(robot, saved_configuration(robot))
    for link in robot.links:
        for part in link.parts:
            actual = robot.world_from_root @ poses[link.name] @ part.link_from_part
            assert np.allclose(actual, part.world_from_part, atol=1e-12)


@pytest.mark.parametrize(("how", "kind"), [("weld", "fixed"), ("separate", "free"), ("drop", "none")])
def test_loose_bodies_may_be_welded_float_or_be_left_out(how, kind):
    log = Diagnostics()
    robot = place(TORN, tree_of(TORN, log, disconnected=how), keys(disconnected=how), log)
    assert [link.name for link in robot.links] == ["a", "b", *(["c", "d", "e"] if how != "drop" else [])]
    stand_ins = {joint.child: (joint.name, joint.parent) for joint in robot.joints if joint.type == kind}
    assert stand_ins == ({name: (f"{name}_{kind}", "a") for name in "ce"} if how != "drop" else {})
    assert codes(log) == ["I-LOOSE"] * 2
    stays(robot)
