"""Relations: which dofs they join, by what factor, with which sign, offset and turns."""

import math

import pytest

from linkwright.stages.graph.mechanism import RelationSpec
from linkwright.stages.graph.passes.relations import with_relations
from linkwright.stages.graph.section import RelationSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Limits, Robot
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from tests.support.robots import at, joint, loop, robot_with

L = 0.01


def spec(kind: str, *connections: str, ratio=1.0, length=L, reverse=False, title="Gear") -> RelationSpec:
    return RelationSpec(title, kind, connections, ratio, length, reverse)


def robot_of(**saved) -> Robot:
    """Joints by the letter of their type: r1, r2, ... revolute, p slide, c cylindrical, and so on."""
    kinds = {
        "r": "revolute",
        "p": "prismatic",
        "c": "cylindrical",
        "s": "pin_slot",
        "q": "planar",
        "l": "parallel",
        "b": "ball",
    }
    joints = [
        joint(kinds[name[0]], "base", f"link_{name}", value, name=name) for name, value in saved.items()
    ]
    return robot_with(joints)


def related(robot: Robot, *specs: RelationSpec, **wanted) -> tuple[Robot, Diagnostics]:
    """The robot with its specs, and what is told; `wanted`: what `relations:` says, by glob."""
    log = Diagnostics()
    keys = {glob: RelationSection.model_validate(said) for glob, said in wanted.items()}
    return with_relations(robot, specs, log, keys), log


def told(log: Diagnostics) -> list[str]:
    return [one.code for one in (*log.problems, *log.found)]


def rules(robot: Robot) -> list[tuple]:
    return [(one.follower, one.driver, one.multiplier, one.offset) for one in robot.relations]


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(
    ("kind", "names", "factor", "driver", "follower"),
    [
        ("GEAR", ("r1", "r2"), 1.5, "r1", "r2"),
        ("LINEAR", ("p1", "p2"), 1.5, "p1", "p2"),
        ("RACK_AND_PINION", ("r1", "p1"), L / math.tau, "r1", "p1"),
        ("RACK_AND_PINION", ("p1", "r1"), math.tau / L, "p1", "r1"),
        ("SCREW", ("c1",), L / math.tau, "c1_turn", "c1_slide"),
        ("GEAR", ("c1", "r1"), 1.5, "c1_turn", "r1"),
        ("GEAR", ("s1", "q1"), 1.5, "s1_turn", "q1_turn"),
        ("GEAR", ("r1", "l1"), 1.5, "r1", "l1_turn"),
        ("LINEAR", ("c1", "s1"), 1.5, "c1_slide", "s1_slide"),
        ("RACK_AND_PINION", ("c1", "p1"), L / math.tau, "c1_turn", "p1"),
        ("RACK_AND_PINION", ("c1", "r1"), math.tau / L, "c1_slide", "r1"),
        ("RACK_AND_PINION", ("q1", "p1"), L / math.tau, "q1_turn", "p1"),
    ],
)
def test_each_relation_joins_its_dofs_by_its_factor(kind, names, factor, driver, follower, reverse) -> None:
    zeros = {"r": [0.0], "p": [0.0], "c": [0.0] * 2, "s": [0.0] * 2, "q": [0.0] * 3, "l": [0.0] * 4}
    robot = robot_of(**{name: zeros[name[0]] for name in ("r1", "r2", "p1", "p2", "c1", "s1", "q1", "l1")})
    found, log = related(robot, spec(kind, *names, ratio=1.5, reverse=reverse))
    want = factor if reverse else -factor
    assert rules(found) == [(follower, driver, pytest.approx(want), 0.0)]
    assert not told(log)


@pytest.mark.parametrize(
    ("one", "why"),
    [
        (spec("LINEAR", "q1", "p1"), "is ambiguous: it may join q1_x and p1, q1_y and p1"),
        (spec("RACK_AND_PINION", "c1", "c2"), "is ambiguous"),
        (spec("GEAR", "r1", "p1"), "needs a turn and a turn, which 'r1' (revolute) and 'p1' (prismatic)"),
        (spec("GEAR", "r1", "b1"), "needs a turn and a turn"),
        (spec("RACK_AND_PINION", "r1", "r2"), "needs a turn and a slide or a slide and a turn"),
        (spec("GEAR", "r1", "close"), "'close', which closes a loop"),
        (spec("GEAR", "r1", ""), "a mate that moves nothing"),
        (spec("GEAR", "r1", "r9"), "'r9', which is not a joint"),
        (spec("GEAR", "r1"), "needs 2 mates, and this one has 1"),
        (spec("GEAR", "r1", "r2", ratio=0.0), "has an invalid ratio 0"),
        (spec("GEAR", "r1", "r2", ratio=-2.0), "has an invalid ratio -2"),
        (spec("RACK_AND_PINION", "r1", "p1", length=0.0), "has an invalid length 0"),
        (spec("SCREW", "c1", length=-1.0), "has an invalid length -1"),
        (spec("CAM", "r1", "r2"), "a CAM relation is not supported"),
    ],
)
def test_what_a_relation_cannot_mean_is_reported_by_name(one: RelationSpec, why: str) -> None:
    robot = robot_of(r1=[0.0], r2=[0.0], p1=[0.0], c1=[0.0] * 2, c2=[0.0] * 2, q1=[0.0] * 3, b1=None)
    closing = loop("revolute", "link_r1", "link_r2", at(0), at(0), name="close")
    found, log = related(robot_with(robot.joints, loops=[closing]), one)
    assert not found.relations
    (only,) = log.found
    assert (only.code, only.where) == ("W-RELATION", "Gear")
    assert why in only.message
    assert only.message.endswith("its joints move independently")


@pytest.mark.parametrize(
    ("one", "why"),
    [
        (spec("GEAR", "r1", "r1"), "the joint 'r1' is related to itself"),
        (spec("SCREW", "s1"), "a SCREW relation needs one CYLINDRICAL mate; 's1' is not one"),
        (spec("SCREW", "r1"), "a SCREW relation needs one CYLINDRICAL mate; 'r1' is not one"),
    ],
)
def test_a_relation_that_contradicts_itself_is_refused(one: RelationSpec, why: str) -> None:
    _, log = related(robot_of(r1=[0.0], s1=[0.0] * 2), one)
    assert [(p.code, p.message) for p in log.problems] == [("E-RELATION", why)]


def test_an_offset_is_kept_and_reported_and_never_traded_for_the_opposite_sign() -> None:
    found, log = related(robot_of(r1=[0.2], r2=[0.5]), spec("GEAR", "r1", "r2"))
    assert rules(found) == [("r2", "r1", -1.0, pytest.approx(0.7))]
    assert told(log) == ["W-RELATION-OFFSET"]
    assert "an offset of 0.7 " in log.found[0].message
    found, log = related(robot_of(r1=[0.2], r2=[0.3]), spec("GEAR", "r1", "r2", ratio=1.5))
    assert rules(found) == [("r2", "r1", -1.5, pytest.approx(0.6))]
    assert told(log) == ["W-RELATION-SIGN"]
    assert "an offset of 0.6 in this relation as it is drawn" in log.found[0].message
    assert log.found[0].hint == (
        "if it moves in the opposite direction, relations: {gear: {invert: true}}; "
        "if not, relations: {gear: {offset: 0.6}}"
    )


@pytest.mark.parametrize(
    ("saved", "keys", "rule", "codes"),
    [
        (0.3, {}, (-1.5, 0.6), ["W-RELATION-SIGN"]),
        (0.3, {"invert": True}, (1.5, 0.0), []),
        (0.3, {"invert": False}, (-1.5, 0.6), ["W-RELATION-OFFSET"]),
        (0.3, {"invert": False, "offset": 0.6}, (-1.5, 0.6), []),
        (0.3, {"offset": 0.6}, (-1.5, 0.6), []),
        (0.3, {"offset": 0}, (-1.5, 0.0), ["I-RELATION-MOVED"]),
        (-0.3, {}, (-1.5, 0.0), []),
        (-0.3, {"invert": True}, (1.5, -0.6), ["W-RELATION-OFFSET"]),
        (-0.3, {"invert": True, "offset": 0.0}, (1.5, 0.0), ["I-RELATION-MOVED"]),
        (0.3, {"drop": True}, None, []),
        (0.3, {"drop": False}, (-1.5, 0.6), ["W-RELATION-SIGN"]),
    ],
)
def test_the_user_has_the_last_word_on_a_relation(saved, keys, rule, codes) -> None:
    found, log = related(robot_of(r1=[0.2], r2=[saved]), spec("GEAR", "r1", "r2", ratio=1.5), gear=keys)
    assert rules(found) == ([("r2", "r1", *map(pytest.approx, rule))] if rule else [])
    assert told(log) == codes
    for one in found.relations:
        values = {dof.name: dof.saved for dof in found.dofs}
        assert values["r2"] == pytest.approx(one.multiplier * values["r1"] + one.offset)


def test_a_relation_is_meant_by_its_name_its_title_or_a_glob_and_later_entries_win() -> None:
    robot = robot_of(r1=[0.0], r2=[0.0], r3=[0.0], r4=[0.0])
    specs = [
        spec("GEAR", "r1", "r2", title="Box/Gear 1"),
        spec("GEAR", "r1", "r3", title="Lid/Gear 1"),
        spec("GEAR", "r1", "r4", title="Gear 9", reverse=True),
    ]

    def signs(**wanted) -> dict[str, float]:
        found, log = related(robot, *specs, **wanted)
        assert not told(log)
        return {one.name: one.multiplier for one in found.relations}

    drawn = {"gear_1": -1.0, "gear_1_2": -1.0, "gear_9": 1.0}
    assert signs() == drawn
    assert signs(gear_1={"invert": True}) == {**drawn, "gear_1": 1.0}
    assert signs(**{"Lid/*": {"invert": True}}) == {**drawn, "gear_1_2": 1.0}
    assert signs(**{"Gear 1": {"invert": True}}) == {**drawn, "gear_1": 1.0, "gear_1_2": 1.0}
    both = {"*": {"invert": True, "drop": True}, "gear_1*": {"drop": False}, "gear_1_2": {"invert": False}}
    assert signs(**both) == {"gear_1": 1.0, "gear_1_2": -1.0}


def test_a_glob_without_a_relation_is_an_error_that_lists_them() -> None:
    robot = robot_of(r1=[0.0], r2=[0.0])
    _, log = related(robot, spec("GEAR", "r1", "r2", title="Box/Gear 1"), **{"Gaer*": {"drop": True}})
    (problem,) = log.problems
    assert (problem.code, problem.where) == ("E-GLOB", "relations")
    assert (problem.message, problem.hint) == ("no relation matches 'Gaer*'", "relations are: Gear 1")
    _, log = related(robot, gear={"drop": True})
    assert log.problems[0].hint == "relations are: none"
    assert not told(related(robot, **{"*": {"drop": True}})[1])


@pytest.mark.parametrize(
    ("kind", "names"), [("CAM", "r1 r2"), ("SCREW", "r1"), ("GEAR", "r1 r1"), ("GEAR", "r2 r1")]
)
def test_what_is_dropped_is_not_reported(kind: str, names: str) -> None:
    robot, right = robot_of(r1=[0.0], r2=[0.0]), spec("GEAR", "r1", "r2", title="Right")
    wrong = spec(kind, *names.split())
    assert told(related(robot, right, wrong)[1])
    found, log = related(robot, right, wrong, gear={"drop": True})
    assert rules(found) == [("r2", "r1", -1.0, 0.0)]
    assert not told(log)


def test_dropping_a_relation_changes_no_name() -> None:
    robot = robot_of(r1=[0.0], r2=[0.0], r3=[0.0])
    specs = [spec("GEAR", "r1", "r2", title="A/Gear"), spec("GEAR", "r1", "r3", title="B/Gear")]
    found, _ = related(robot, *specs, gear={"drop": True})
    assert [one.name for one in found.relations] == ["gear_2"]


def test_an_offset_of_a_turn_is_the_least_that_its_limits_allow() -> None:
    """-2.4 − 1.2 is 3.6, or 3.6 − 2π = -2.68: with that the follower would stand at -5.08."""
    limits = {"r2": Limits(-2.5, 2.5)}
    joints = [
        joint("revolute", "base", "link_r1", [2.4], name="r1"),
        joint("revolute", "base", "link_r2", [1.2], name="r2", limits=limits),
    ]
    found, log = related(robot_with(joints), spec("GEAR", "r1", "r2"))
    assert rules(found) == [("r2", "r1", -1.0, pytest.approx(3.6))]
    assert found.dofs[1].saved == pytest.approx(1.2)
    assert told(log) == ["W-RELATION-OFFSET"]


def test_a_part_goes_where_an_offset_of_the_users_puts_it() -> None:
    """Parts count as drawn in the pose that the relations give: nothing else could be checked."""
    robot = robot_of(r1=[0.2], r2=[0.3])
    found, _ = related(robot, spec("GEAR", "r1", "r2"), gear={"offset": 0.0})
    poses = link_poses(found, saved_configuration(found))
    for link in found.links:
        for part in link.parts:
            pose = found.world_from_root @ poses[link.name] @ part.link_from_part
            assert abs(part.world_from_part - pose).max() < 1e-12


def test_a_follower_is_saved_at_the_turn_that_its_driver_gives() -> None:
    found, log = related(robot_of(r1=[2.5], r2=[-5.0 + math.tau]), spec("GEAR", "r1", "r2", ratio=2.0))
    assert rules(found) == [("r2", "r1", -2.0, 0.0)]
    assert found.dofs[1].saved == pytest.approx(-5.0)
    assert not told(log)


def test_a_screw_far_out_has_turned_often() -> None:
    """23 mm at 5 mm a turn: the pose shows the turn only up to whole ones, the slide shows which."""
    angle = -23 / 5 * math.tau
    robot = robot_of(c1=[0.023, math.remainder(angle, math.tau)], r1=[0.1])
    found, log = related(robot, spec("SCREW", "c1", length=0.005))
    assert rules(found) == [("c1_slide", "c1_turn", pytest.approx(-0.005 / math.tau), 0.0)]
    assert {d.name: d.saved for d in found.dofs}["c1_turn"] == pytest.approx(angle)
    assert not told(log)


def test_a_motor_that_turns_a_screw_by_a_gear_has_turned_as_the_slide_tells() -> None:
    angle = -23 / 5 * math.tau
    motor = -angle / 3 * 2
    robot = robot_of(c1=[0.023, math.remainder(angle, math.tau)], r1=[math.remainder(motor, math.tau)])
    specs = spec("GEAR", "r1", "c1", ratio=1.5, title="A"), spec("SCREW", "c1", length=0.005, title="B")
    found, log = related(robot, *specs)
    saved = {dof.name: dof.saved for dof in found.dofs}
    assert not told(log)
    assert [(one.name, one.follower, one.driver) for one in found.relations] == [
        ("b", "c1_slide", "r1"),
        ("a", "c1_turn", "r1"),
    ]
    for one in found.relations:
        assert saved[one.follower] == pytest.approx(one.multiplier * saved[one.driver] + one.offset)
    assert saved["r1"] == pytest.approx(motor)


def test_a_chain_is_flattened_with_its_offsets() -> None:
    robot = robot_of(r1=[0.1], r2=[0.4], r3=[-1.0])
    specs = spec("GEAR", "r1", "r2", ratio=2, title="A"), spec("GEAR", "r2", "r3", ratio=3, title="B")
    found, log = related(robot, *specs)
    assert rules(found) == [
        ("r2", "r1", -2.0, pytest.approx(0.6)),
        ("r3", "r1", 6.0, pytest.approx(-1.6)),
    ]
    assert told(log) == ["W-RELATION-OFFSET"] * 2


def test_what_two_would_drive_drives_the_second_whatever_their_order() -> None:
    robot = robot_of(r0=[0.4], r1=[-0.2], r2=[0.1])
    specs = [spec("GEAR", "r0", "r1", ratio=0.5, title="A"), spec("GEAR", "r2", "r1", ratio=2, title="B")]
    for order in (specs, specs[::-1]):
        found, log = related(robot, *order)
        assert rules(found) == [("r1", "r0", -0.5, 0.0), ("r2", "r0", 0.25, 0.0)]
        assert not told(log)


def test_a_chain_that_is_drawn_from_its_end_is_driven_from_its_start() -> None:
    robot = robot_of(r1=[0.1], r2=[-0.2], r3=[0.6])
    specs = spec("GEAR", "r2", "r3", ratio=3, title="A"), spec("GEAR", "r1", "r2", ratio=2, title="B")
    assert rules(related(robot, *specs)[0]) == [("r2", "r1", -2.0, 0.0), ("r3", "r1", 6.0, 0.0)]


def test_a_bond_that_is_turned_round_keeps_its_offset() -> None:
    robot = robot_of(r0=[0.3], r1=[0.1], r2=[0.9 / 7])
    specs = [spec("GEAR", "r0", "r1", ratio=3, title="A"), spec("GEAR", "r2", "r1", ratio=7, title="B")]
    found, log = related(robot, *specs)
    assert [one.message.split(" of ")[1].split()[0] for one in log.found] == ["1", "1"]
    assert rules(found) == [("r1", "r0", -3.0, pytest.approx(1.0)), ("r2", "r0", pytest.approx(3 / 7), 0.0)]


def test_trees_are_turned_to_one_driver_where_turning_one_bond_is_not_enough() -> None:
    robot = robot_of(r1=[0.0], r2=[0.0], r3=[0.0], r4=[0.0])
    pairs = [("r1", "r2"), ("r3", "r4"), ("r2", "r4")]
    specs = [spec("GEAR", *pair, title=f"G{n}", ratio=2) for n, pair in enumerate(pairs)]
    found, log = related(robot, *specs)
    assert not told(log)
    assert rules(found) == [("r2", "r1", -2, 0), ("r3", "r1", -2, 0), ("r4", "r1", 4, 0)]
    assert [one.name for one in found.relations] == ["g0", "g1", "g2"]


@pytest.mark.parametrize("pairs", [["r1 r2", "r2 r1"], ["r1 r2", "r1 r2"], ["r1 r2", "r2 r3", "r3 r1"]])
def test_dofs_that_are_related_twice_are_refused(pairs: list[str]) -> None:
    specs = [spec("GEAR", *pair.split(), title=f"G{n}") for n, pair in enumerate(pairs)]
    _, log = related(robot_of(r1=[0.0], r2=[0.0], r3=[0.0]), *specs)
    assert [(p.code, p.where) for p in log.problems] == [("E-RELATION", f"G{len(pairs) - 1}")]


def test_names_are_free_and_do_not_depend_on_the_order() -> None:
    robot = robot_of(r1=[0.0], r2=[0.0], r3=[0.0])
    specs = [spec("GEAR", "r1", "r2", title="Box/R1"), spec("GEAR", "r1", "r3", title="Lid/!")]
    for order in (specs, specs[::-1]):
        found, _ = related(robot, *order)
        assert [one.name for one in found.relations] == ["r1_2", "relation"]


def test_limits_that_exclude_what_the_driver_gives_are_reported() -> None:
    def limited(name, low, high):
        return joint("revolute", "base", f"link_{name}", [0.0], name=name, limits={name: Limits(low, high)})

    robot = robot_with(
        [limited("r1", 0.5, 1.0), limited("r2", 0.0, 3.0), limited("r3", None, -0.9), limited("r4", None, -2)]
    )
    specs = [spec("GEAR", "r1", name, title=name) for name in ("r2", "r3", "r4")]
    _, log = related(robot, *specs)
    assert [(one.code, one.where) for one in log.found] == [
        ("W-RELATION-LIMIT", "r2"),
        ("W-RELATION-LIMIT", "r4"),
    ]
    assert "[-1, -0.5]" in log.found[0].message
