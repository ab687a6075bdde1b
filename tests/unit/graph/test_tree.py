"""Root, tree and cut, on mechanisms made by hand."""

import random
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.graph.mechanism import Connection, Marker, Mechanism, RelationSpec, RigidBody
from linkwright.stages.graph.onshape.mates.joints import JOINT_TYPES, dofs_of
from linkwright.stages.graph.robot_from_tree import place
from linkwright.stages.graph.root import choose_root
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.graph.tree import Tree, spanning_tree
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import Disconnected, NoRoot
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Inertial, MateRef, Part, Provenance, frozen
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration

IDENTITY = frozen(np.eye(4))


def body(name: str, mass: float = 1.0, held: str = "", **more: object) -> RigidBody:
    inertial = Inertial(mass, frozen(np.zeros(3)), frozen(np.eye(3) * mass))
    part = Part((name,), f"{name} <1>", "p", None, IDENTITY, IDENTITY, inertial, 1.0)
    parts = () if name == "world" else (part,)
    return replace(RigidBody(name, (name,), parts, frozenset({name, f"{name} <1>"}), held, IDENTITY), **more)


def pose(seed: int) -> np.ndarray:
    drawn = np.random.default_rng(seed)
    return frozen(from_parts(rotation_from_rpy(tuple(drawn.uniform(-3, 3, 3))), drawn.uniform(-1, 1, 3)))


def mate(
    name: str, first: int, second: int, kind: str = "REVOLUTE", seed: int = 1, limits: dict | None = None
) -> Connection:
    frame = pose(seed)
    return Connection(
        name=name,
        type=JOINT_TYPES[kind],
        bodies=(first, second),
        world_from_frames=(frame, frame),
        dofs=dofs_of(name, kind, limits or {}, np.eye(4)),
        residual=0.0,
        ref=MateRef((), name, name.title(), kind),
        title=name.title(),
    )


def mechanism(bodies: list[RigidBody], connections: list[Connection], **more: object) -> Mechanism:
    made = Mechanism(tuple(bodies), tuple(connections), (), (), Provenance("", "", "", ""))
    return replace(made, **more)


def keys(**root: object) -> GraphSections:
    cut = root.pop("cut", ())
    return GraphSections.model_validate({"root": root, "loops": {"cut": cut}})


def tree_of(drawn: Mechanism, log: Diagnostics | None = None, **root: object) -> Tree:
    return spanning_tree(drawn, keys(**root), log or Diagnostics())


CHAIN = mechanism(
    [body("a"), body("b", 5.0), body("c"), body("d")],
    [mate("ab", 0, 1), mate("bc", 1, 2), mate("cd", 2, 3)],
)


def test_auto_is_what_is_held_else_the_heaviest() -> None:
    assert tree_of(CHAIN).root == 1
    held = replace(CHAIN, bodies=(*CHAIN.bodies[:3], body("d", fixed_reason="d is fixed")))
    assert tree_of(held).root == 3


def test_central_is_the_nearest_to_all_others_and_ignores_what_is_held() -> None:
    bodies = [body("a", fixed_reason="fixed"), body("b"), body("c"), body("d", 9.0), body("e")]
    drawn = mechanism(bodies, [mate(f"m{i}", i, i + 1) for i in range(4)])
    assert tree_of(drawn, select="central").root == 2


def test_a_name_or_a_glob_selects_by_link_or_by_instance() -> None:
    assert tree_of(CHAIN, select="c").root == 2
    assert tree_of(CHAIN, select="d <*>").root == 3
    named = mechanism([body("a"), body("b", titles=frozenset({"Pump [x] <1>"}))], [])
    for wanted in ("Pump [x] <1>", "Pump [x]", "Pump*"):
        assert choose_root(named, keys(select=wanted).root)[0] == 1
    with pytest.raises(NoRoot, match="no links match 'x'"):
        tree_of(CHAIN, select="x")
    with pytest.raises(NoRoot, match="4 links match"):
        tree_of(CHAIN, select="*")


def test_a_frame_gives_the_root_its_link_and_its_pose() -> None:
    marker = Marker("tip", "Arm/Tip", 2, pose(7), "Tip")
    drawn = replace(CHAIN, markers=(marker,))
    for wanted in ("tip", "Tip", "Arm/Tip"):
        tree = tree_of(drawn, frame=wanted)
        assert tree.root == 2
        assert tree.world_from_root is marker.world_from_frame
    with pytest.raises(NoRoot, match="on the link 'c', but the root is 'a'"):
        tree_of(drawn, frame="tip", select="a")
    with pytest.raises(NoRoot, match="no mate connectors are called 'hand'"):
        tree_of(drawn, frame="hand")


def test_what_moves_against_the_origin_makes_it_the_root() -> None:
    drawn = mechanism([body("world", fixed_reason="origin"), body("a", 9.0)], [mate("rail", 1, 0, "SLIDER")])
    assert tree_of(drawn).root == 0
    with pytest.raises(NoRoot, match="'a' cannot be the root: Rail"):
        tree_of(drawn, select="a")
    log = Diagnostics()
    robot = place(drawn, tree_of(drawn, base="free"), keys(base="free"), log)
    assert robot.base.fixed
    assert [problem.code for problem in log.problems] == ["E-BASE"]


def ring(*kinds: str, **limits: dict) -> Mechanism:
    """A single loop of bodies b0, b1, ... with mates m0 (b0 to b1), m1, ..."""
    count = len(kinds)
    mates = [
        mate(f"m{i}", i, (i + 1) % count, kind, limits=limits.get(f"m{i}")) for i, kind in enumerate(kinds)
    ]
    return mechanism([body(f"b{i}", 1.0 + (i == 0)) for i in range(count)], mates)


@pytest.mark.parametrize(
    ("kinds", "cut"),
    [
        (("REVOLUTE", "REVOLUTE", "REVOLUTE"), "m2"),
        (("REVOLUTE", "SLIDER", "SLIDER"), "m0"),
        (("SLIDER", "CYLINDRICAL", "SLIDER"), "m1"),
        (("BALL", "REVOLUTE", "CYLINDRICAL", "SLIDER"), "m0"),
        (("REVOLUTE", "REVOLUTE"), "m1"),
    ],
)
def test_loops_of_any_size_are_cut_at_balls_and_hinges_first(kinds: tuple[str, ...], cut: str) -> None:
    assert [connection.name for connection in tree_of(ring(*kinds)).cut] == [cut]


def test_limited_and_related_mates_stay_in_the_tree() -> None:
    limits = {"limitAxialZMin": -1.0, "limitAxialZMax": 1.0}
    drawn = ring("REVOLUTE", "REVOLUTE", "REVOLUTE", m1=limits, m2=limits)
    assert [connection.name for connection in tree_of(drawn).cut] == ["m0"]
    spec = RelationSpec("Gear", "GEAR", ("m0", "m1"), 1.0, 0.0, False)
    assert [connection.name for connection in tree_of(replace(drawn, relations=(spec,))).cut] == ["m2"]


def test_the_user_says_where_loops_are_cut() -> None:
    drawn = ring("REVOLUTE", "SLIDER", "REVOLUTE")
    assert [connection.name for connection in tree_of(drawn, cut=("M1",)).cut] == ["m1"]
    log = Diagnostics()
    tree_of(CHAIN, log, cut=("ab", "m7"))
    assert [found.code for found in log.found] == ["W-LOOP-CUT"]
    assert [(one.code, one.where) for one in log.problems] == [("E-GLOB", "loops.cut")]


def test_neither_order_nor_root_decides_what_is_cut() -> None:
    drawn = ring("REVOLUTE", "CYLINDRICAL", "REVOLUTE", "BALL", "REVOLUTE")
    extra = [mate("x", 0, 2), mate("y", 1, 3, "SLIDER"), mate("z", 4, 1)]
    connections = [*drawn.connections, *extra]
    expected = {connection.name for connection in tree_of(replace(drawn, connections=tuple(connections))).cut}
    for seed in range(10):
        random.Random(seed).shuffle(connections)
        tree = tree_of(replace(drawn, connections=tuple(connections)), select=f"b{seed % 5}")
        assert {connection.name for connection in tree.cut} == expected
        assert set(tree.order) == set(range(5))
        seen = {tree.root}
        for edge in tree.edges:
            assert edge.parent in seen
            seen.add(edge.child)


TORN = mechanism(
    [body("a", 3.0), body("b"), body("c", 2.0), body("d"), body("e")],
    [mate("ab", 0, 1), mate("cd", 2, 3)],
)


def test_what_hangs_on_nothing_is_an_error_that_lists_it_with_the_ways_out() -> None:
    with pytest.raises(Disconnected) as caught:
        tree_of(TORN)
    assert [(p.code, p.where) for p in caught.value.problems] == [("E-LOOSE", "c <1>"), ("E-LOOSE", "e <1>")]
    assert "weld" in caught.value.hint
    assert "separate" in caught.value.hint


@pytest.mark.parametrize(("how", "kind"), [("weld", "fixed"), ("separate", "free")])
def test_it_may_be_welded_or_float_on_its_own(how: str, kind: str) -> None:
    log = Diagnostics()
    tree = tree_of(TORN, log, disconnected=how)
    robot = place(TORN, tree, keys(disconnected=how), log)
    assert [link.name for link in robot.links] == ["a", "b", "c", "d", "e"]
    stand_ins = {joint.child: (joint.name, joint.parent) for joint in robot.joints if joint.type == kind}
    assert stand_ins == {"c": (f"c_{kind}", "a"), "e": (f"e_{kind}", "a")}
    assert [found.code for found in log.found] == ["I-LOOSE"] * 2
    poses = link_poses(robot, saved_configuration(robot))
    for link in robot.links:
        for part in link.parts:
            assert np.allclose(poses[link.name] @ part.link_from_part, part.world_from_part, atol=1e-12)


def test_it_may_be_left_out() -> None:
    log = Diagnostics()
    robot = place(TORN, tree_of(TORN, log, disconnected="drop"), keys(disconnected="drop"), log)
    assert [link.name for link in robot.links] == ["a", "b"]
    assert len(log.found) == 2


def test_a_root_of_its_own_frame_keeps_the_parts_where_they_are() -> None:
    drawn = replace(CHAIN, markers=(Marker("tip", "Tip", 2, pose(7), "Tip"),))
    robot = place(drawn, tree_of(drawn, frame="tip"), keys(frame="tip"), Diagnostics())
    poses = link_poses(robot, saved_configuration(robot))
    for link in robot.links:
        for part in link.parts:
            found = robot.world_from_root @ poses[link.name] @ part.link_from_part
            assert np.allclose(found, part.world_from_part, atol=1e-12)
