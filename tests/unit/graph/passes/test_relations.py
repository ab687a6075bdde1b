"""Relations: which dofs they join, by what factor, with which sign, offset and turns."""

import math

import pytest

from linkwright.stages.graph.mechanism import RelationSpec
from linkwright.stages.graph.passes.relations import with_relations
from linkwright.stages.graph.section import RelationSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Limits
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from tests.support.reported import codes, only, reports
from tests.support.robots import at, joint, loop, robot_with

L = 0.01


def spec(kind, *connections, ratio=1.0, length=L, reverse=False, title="Gear"):
    return RelationSpec(title, kind, connections, ratio, length, reverse)


KINDS = {
    "r": ("revolute", 1), "p": ("prismatic", 1), "c": ("cylindrical", 2), "s": ("pin_slot", 2),
    "q": ("planar", 3), "l": ("parallel", 4), "b": ("ball", 0),
}  # fmt: skip
"""The types of joints by their letters, and how many values each has."""


def robot_of(**saved):
    """Joints by the letter of their type: r1, r2, ... revolute, p slide, c cylindrical, and so on."""
    kinds = ((KINDS[name[0]][0], name, value) for name, value in saved.items())
    return robot_with([joint(kind, "base", f"link_{name}", value, name=name) for kind, name, value in kinds])


def at_zero(names):
    """These joints, all saved at zero."""
    return robot_of(**{name: [0.0] * KINDS[name[0]][1] or None for name in names.split()})


def related(robot, *specs, **by_glob):
    """The robot with its specs, and what is told; `by_glob`: what `relations:` says, by glob."""
    log = Diagnostics()
    keys = {glob: RelationSection.model_validate(said) for glob, said in by_glob.items()}
    return with_relations(robot, specs, log, keys), log


def gears(*rows):
    """Gears as "r1 r2 1.5": two joints and a ratio; the titles are A, B, ..."""
    parts = [row.split() for row in rows]
    return [spec("GEAR", a, b, ratio=float(n), title="ABC"[i]) for i, (a, b, n) in enumerate(parts)]


def rules(robot):
    return [(r.follower, r.driver, r.multiplier, r.offset) for r in robot.relations]


def saved_of(robot):
    return {dof.name: dof.saved for dof in robot.dofs}


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(
    ("kind", "names", "factor", "driver", "follower"),
    [
        ("GEAR", ("r1", "r2"), 1.5, "r1", "r2"), ("LINEAR", ("p1", "p2"), 1.5, "p1", "p2"),
        ("RACK_AND_PINION", ("r1", "p1"), L / math.tau, "r1", "p1"),
        ("RACK_AND_PINION", ("p1", "r1"), math.tau / L, "p1", "r1"),
        ("SCREW", ("c1",), L / math.tau, "c1_turn", "c1_slide"), ("GEAR", ("c1", "r1"), 1.5, "c1_turn", "r1"),
        ("GEAR", ("s1", "q1"), 1.5, "s1_turn", "q1_turn"), ("GEAR", ("r1", "l1"), 1.5, "r1", "l1_turn"),
        ("LINEAR", ("c1", "s1"), 1.5, "c1_slide", "s1_slide"),
        ("RACK_AND_PINION", ("c1", "p1"), L / math.tau, "c1_turn", "p1"),
        ("RACK_AND_PINION", ("c1", "r1"), math.tau / L, "c1_slide", "r1"),
        ("RACK_AND_PINION", ("q1", "p1"), L / math.tau, "q1_turn", "p1"),
    ],
)  # fmt: skip
def test_a_relation_joins_its_dofs_by_its_factor(kind, names, factor, driver, follower, reverse):
    robot = at_zero("r1 r2 p1 p2 c1 s1 q1 l1")
    joined, log = related(robot, spec(kind, *names, ratio=1.5, reverse=reverse))
    assert rules(joined) == [(follower, driver, pytest.approx(factor if reverse else -factor), 0.0)]
    assert not codes(log)


@pytest.mark.parametrize(
    ("relation", "why"),
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
def test_a_relation_without_a_meaning_is_reported(relation, why):
    closing = loop("revolute", "link_r1", "link_r2", at(0), at(0), name="close")
    joined, log = related(robot_with(at_zero("r1 r2 p1 c1 c2 q1 b1").joints, loops=[closing]), relation)
    assert not joined.relations
    note = only(log)
    assert (note.code, note.where) == ("W-RELATION", "Gear")
    assert why in note.message
    assert note.message.endswith("its joints move independently")


@pytest.mark.parametrize(
    ("relation", "why"),
    [
        (spec("GEAR", "r1", "r1"), "the joint 'r1' is related to itself"),
        (spec("SCREW", "s1"), "a SCREW relation needs one CYLINDRICAL mate; 's1' is of another type"),
        (spec("SCREW", "r1"), "a SCREW relation needs one CYLINDRICAL mate; 'r1' is of another type"),
    ],
)
def test_a_relation_that_contradicts_itself_is_refused(relation, why):
    _, log = related(at_zero("r1 s1"), relation)
    assert [(p.code, p.message) for p in log.problems] == [("E-RELATION", why)]


def test_an_offset_is_never_traded_for_the_opposite_sign():
    joined, log = related(robot_of(r1=[0.2], r2=[0.5]), spec("GEAR", "r1", "r2"))
    assert rules(joined) == [("r2", "r1", -1.0, pytest.approx(0.7))]
    assert "an offset of 0.7 " in only(log, "W-RELATION-OFFSET").message
    joined, log = related(robot_of(r1=[0.2], r2=[0.3]), spec("GEAR", "r1", "r2", ratio=1.5))
    assert rules(joined) == [("r2", "r1", -1.5, pytest.approx(0.6))]
    note = only(log, "W-RELATION-SIGN")
    assert "an offset of 0.6 in this relation as it is drawn" in note.message
    assert note.hint == (
        "if it moves in the opposite direction, relations: {gear: {invert: true}}; "
        "if not, relations: {gear: {offset: 0.6}}"
    )


@pytest.mark.parametrize(
    ("saved", "keys", "rule", "reported"),
    [
        (0.3, {}, (-1.5, 0.6), ["W-RELATION-SIGN"]), (0.3, {"invert": True}, (1.5, 0.0), []),
        (0.3, {"invert": False}, (-1.5, 0.6), ["W-RELATION-OFFSET"]),
        (0.3, {"invert": False, "offset": 0.6}, (-1.5, 0.6), []), (0.3, {"offset": 0.6}, (-1.5, 0.6), []),
        (0.3, {"offset": 0}, (-1.5, 0.0), ["I-RELATION-MOVED"]), (-0.3, {}, (-1.5, 0.0), []),
        (-0.3, {"invert": True}, (1.5, -0.6), ["W-RELATION-OFFSET"]),
        (-0.3, {"invert": True, "offset": 0.0}, (1.5, 0.0), ["I-RELATION-MOVED"]),
        (0.3, {"drop": True}, None, []), (0.3, {"drop": False}, (-1.5, 0.6), ["W-RELATION-SIGN"]),
    ],
)  # fmt: skip
def test_the_user_has_the_last_word_on_a_relation(saved, keys, rule, reported):
    joined, log = related(robot_of(r1=[0.2], r2=[saved]), spec("GEAR", "r1", "r2", ratio=1.5), gear=keys)
    assert rules(joined) == ([("r2", "r1", *map(pytest.approx, rule))] if rule else [])
    assert codes(log) == reported
    for relation in joined.relations:
        values = saved_of(joined)
        assert values["r2"] == pytest.approx(relation.multiplier * values["r1"] + relation.offset)


def test_relations_match_by_name_title_or_glob_and_the_last_wins():
    robot = at_zero("r1 r2 r3 r4")
    specs = [
        spec("GEAR", "r1", "r2", title="Box/Gear 1"),
        spec("GEAR", "r1", "r3", title="Lid/Gear 1"),
        spec("GEAR", "r1", "r4", title="Gear 9", reverse=True),
    ]

    def signs(**by_glob):
        joined, log = related(robot, *specs, **by_glob)
        assert not codes(log)
        return {relation.name: relation.multiplier for relation in joined.relations}

    drawn = {"gear_1": -1.0, "gear_1_2": -1.0, "gear_9": 1.0}
    assert signs() == drawn
    assert signs(gear_1={"invert": True}) == {**drawn, "gear_1": 1.0}
    assert signs(**{"Lid/*": {"invert": True}}) == {**drawn, "gear_1_2": 1.0}
    assert signs(**{"Gear 1": {"invert": True}}) == {**drawn, "gear_1": 1.0, "gear_1_2": 1.0}
    both = {"*": {"invert": True, "drop": True}, "gear_1*": {"drop": False}, "gear_1_2": {"invert": False}}
    assert signs(**both) == {"gear_1": 1.0, "gear_1_2": -1.0}


def test_a_glob_without_a_relation_is_an_error_that_lists_them():
    robot = at_zero("r1 r2")
    _, log = related(robot, spec("GEAR", "r1", "r2", title="Box/Gear 1"), **{"Gaer*": {"drop": True}})
    problem = only(log, "E-GLOB")
    assert (problem.where, problem.message) == ("relations", "no relation matches 'Gaer*'")
    assert problem.hint == "relations are: Gear 1"
    assert only(related(robot, gear={"drop": True})[1]).hint == "relations are: none"
    assert not codes(related(robot, **{"*": {"drop": True}})[1])


@pytest.mark.parametrize(
    ("kind", "names"), [("CAM", "r1 r2"), ("SCREW", "r1"), ("GEAR", "r1 r1"), ("GEAR", "r2 r1")]
)
def test_a_dropped_relation_is_not_reported(kind, names):
    robot, right, wrong = (
        at_zero("r1 r2"),
        spec("GEAR", "r1", "r2", title="Right"),
        spec(kind, *names.split()),
    )
    assert codes(related(robot, right, wrong)[1])
    joined, log = related(robot, right, wrong, gear={"drop": True})
    assert (rules(joined), codes(log)) == ([("r2", "r1", -1.0, 0.0)], [])


def test_names_do_not_depend_on_order_or_dropped_relations():
    robot = at_zero("r1 r2 r3")
    specs = [spec("GEAR", "r1", "r2", title="Box/R1"), spec("GEAR", "r1", "r3", title="Lid/!")]
    for order in (specs, specs[::-1]):
        joined, _ = related(robot, *order)
        assert [relation.name for relation in joined.relations] == ["r1_2", "relation"]
    specs = [spec("GEAR", "r1", "r2", title="A/Gear"), spec("GEAR", "r1", "r3", title="B/Gear")]
    joined, _ = related(robot, *specs, gear={"drop": True})
    assert [relation.name for relation in joined.relations] == ["gear_2"]


def test_an_offset_of_a_turn_is_the_least_that_its_limits_allow():
    """-2.4 − 1.2 is 3.6, or 3.6 − 2π = -2.68: with that the follower would stand at -5.08."""
    limits = {"r2": Limits(-2.5, 2.5)}
    values = {"r1": 2.4, "r2": 1.2}
    joints = [joint("revolute", "base", f"link_{n}", [q], name=n, limits=limits) for n, q in values.items()]
    joined, log = related(robot_with(joints), spec("GEAR", "r1", "r2"))
    assert rules(joined) == [("r2", "r1", -1.0, pytest.approx(3.6))]
    assert (joined.dofs[1].saved, codes(log)) == (pytest.approx(1.2), ["W-RELATION-OFFSET"])


def test_a_part_goes_where_an_offset_of_the_users_puts_it():
    """Parts count as drawn in the pose that the relations give: nothing else could be checked."""
    robot = robot_of(r1=[0.2], r2=[0.3])
    joined, _ = related(robot, spec("GEAR", "r1", "r2"), gear={"offset": 0.0})
    poses = link_poses(joined, saved_configuration(joined))
    for link in joined.links:
        for part in link.parts:
            pose = joined.world_from_root @ poses[link.name] @ part.link_from_part
            assert abs(part.world_from_part - pose).max() < 1e-12


ANGLE = -23 / 5 * math.tau
"""23 mm at 5 mm a turn: the pose shows the turn only up to whole ones, the slide shows which."""


def test_a_screw_far_out_has_turned_often():
    robot = robot_of(c1=[0.023, math.remainder(ANGLE, math.tau)], r1=[0.1])
    joined, log = related(robot, spec("SCREW", "c1", length=0.005))
    assert rules(joined) == [("c1_slide", "c1_turn", pytest.approx(-0.005 / math.tau), 0.0)]
    assert (saved_of(joined)["c1_turn"], codes(log)) == (pytest.approx(ANGLE), [])


def test_a_motor_of_a_screw_has_turned_as_the_slide_tells():
    motor = -ANGLE / 3 * 2
    robot = robot_of(c1=[0.023, math.remainder(ANGLE, math.tau)], r1=[math.remainder(motor, math.tau)])
    joined, log = related(robot, *gears("r1 c1 1.5"), spec("SCREW", "c1", length=0.005, title="B"))
    saved = saved_of(joined)
    assert not codes(log)
    ties = [(relation.name, relation.follower, relation.driver) for relation in joined.relations]
    assert ties == [("b", "c1_slide", "r1"), ("a", "c1_turn", "r1")]
    for relation in joined.relations:
        driven = relation.multiplier * saved[relation.driver] + relation.offset
        assert saved[relation.follower] == pytest.approx(driven)
    assert saved["r1"] == pytest.approx(motor)


@pytest.mark.parametrize(
    ("saved", "specs", "flat", "offsets"),
    [
        ((0.1, 0.4, -1.0), ("r1 r2 2", "r2 r3 3"), [("r2", -2, 0.6), ("r3", 6, -1.6)], 2),
        ((0.1, -0.2, 0.6), ("r2 r3 3", "r1 r2 2"), [("r2", -2, 0), ("r3", 6, 0)], 0),
        ((0.4, -0.2, 0.1), ("r1 r2 0.5", "r3 r2 2"), [("r2", -0.5, 0), ("r3", 0.25, 0)], 0),
        ((0.3, 0.1, 0.9 / 7), ("r1 r2 3", "r3 r2 7"), [("r2", -3, 1), ("r3", 3 / 7, 0)], 2),
    ],
    ids=["a chain", "from its end", "what two would drive", "a bond that is turned round"],
)
def test_relations_are_flattened_to_a_single_driver(saved, specs, flat, offsets):
    robot, specs = robot_of(r1=saved[:1], r2=saved[1:2], r3=saved[2:]), gears(*specs)
    for order in (specs, specs[::-1]):
        joined, log = related(robot, *order)
        expected = [(name, "r1", pytest.approx(k), pytest.approx(off)) for name, k, off in flat]
        assert rules(joined) == expected
        assert codes(log) == ["W-RELATION-OFFSET"] * offsets


def test_trees_of_relations_are_turned_to_a_single_driver():
    joined, log = related(at_zero("r1 r2 r3 r4"), *gears("r1 r2 2", "r3 r4 2", "r2 r4 2"))
    assert not codes(log)
    assert rules(joined) == [("r2", "r1", -2, 0), ("r3", "r1", -2, 0), ("r4", "r1", 4, 0)]
    assert [relation.name for relation in joined.relations] == ["a", "b", "c"]


@pytest.mark.parametrize("pairs", ["r1 r2, r2 r1", "r1 r2, r1 r2", "r1 r2, r2 r3, r3 r1"])
def test_dofs_that_are_related_twice_are_refused(pairs):
    specs = gears(*(f"{pair} 1" for pair in pairs.split(", ")))
    _, log = related(at_zero("r1 r2 r3"), *specs)
    assert [(p.code, p.where) for p in log.problems] == [("E-RELATION", specs[-1].title)]


def test_limits_that_exclude_what_the_driver_gives_are_reported():
    ranges = {"r1": (0.5, 1.0), "r2": (0.0, 3.0), "r3": (None, -0.9), "r4": (None, -2)}
    limits = {name: Limits(*ends) for name, ends in ranges.items()}
    robot = robot_with([joint("revolute", "base", f"link_{n}", [0.0], name=n, limits=limits) for n in ranges])
    _, log = related(robot, *(spec("GEAR", "r1", name, title=name) for name in ("r2", "r3", "r4")))
    assert reports(log) == [("W-RELATION-LIMIT", "r2"), ("W-RELATION-LIMIT", "r4")]
    assert "[-1, -0.5]" in log.notes[0].message
