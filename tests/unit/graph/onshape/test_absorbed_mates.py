"""The limits and coordinates of mates that another mate between the same bodies absorbs, and mates that none
does."""

from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.graph.onshape.assembly import Entity
from linkwright.stages.graph.onshape.mates.parallel import Absorbed, CombinedMates
from linkwright.stages.robot.model.robot import frozen
from tests.support.building import robot_of
from tests.unit.graph.onshape.test_parallel_mates import ONE, OTHER, Pair, X, Z, frame, limits_of, shift


@pytest.mark.parametrize(("axis", "first"), [(-Z, ONE), (Z, OTHER)])
def test_limits_of_a_second_hinge_hold_for_the_first(axis, first):
    pair = Pair()
    pair.mate("a", "REVOLUTE", frame(), 0.5, limits={"limitAxialZMin": -1.0, "limitAxialZMax": 2.0})
    # Turns the other way round and stands at -0.2 where the first is at 0.5: q' = 0.3 - q.
    upper = frame(axis, (0, 0, 1))
    pair.mate("b", "REVOLUTE", upper, -0.2, first=first, limits={"limitAxialZMax": 0.9})
    assert limits_of(pair.only()) == {"limitAxialZMin": -0.6, "limitAxialZMax": 2.0}


def test_limits_beyond_half_a_turn_count_from_the_saved_pose():
    pair = Pair()
    pair.mate("a", "REVOLUTE", frame(), 0.1)
    low, saved, high = np.radians([170, 190, 250])
    # At 190°, which the frames alone tell as -170°.
    limits = {"limitAxialZMin": low, "limitAxialZMax": high}
    pair.mate("b", "REVOLUTE", frame(Z, (0, 0, 1)), saved, limits=limits)
    expected = {"limitAxialZMin": 0.1 + low - saved, "limitAxialZMax": 0.1 + high - saved}
    assert limits_of(pair.only()) == expected


def test_a_slide_that_follows_in_proportion_bounds_the_joint():
    pair = Pair()
    lean = np.array([3.0, 4.0, 0.0]) / 5
    pair.mate("a", "SLIDER", frame(lean, (0, 0, 1)), 0.5)
    pair.mate("b", "PLANAR", np.eye(4), 0.0, 0.0, 0.4, limits={"limitXMax": 0.6, "limitYMin": -0.8})
    assert limits_of(pair.only()) == {"limitZMin": -0.5, "limitZMax": 1.5}


CONE = {"limitEulerConeAngleMax": 0.4}


@pytest.mark.parametrize(
    ("first", "second", "limits", "lost"),
    [
        (("REVOLUTE", frame()), ("PLANAR", frame(Z, (1, 0, 0)), 0.3, 0.2, 0.4), {"limitXMax": 0.6}, True),
        (("REVOLUTE", frame()), ("CYLINDRICAL", frame(), 0.3, 0.2), {"limitZMax": 0.6}, False),
        (("REVOLUTE", frame()), ("CYLINDRICAL", frame(), 0.3, 0.2), {"limitZMax": 0.2}, True),
        (("BALL", frame(), (1, 0.1, 0, 0)), ("BALL", frame(X), (1, 0, 0.2, 0)), CONE, True),
    ],
    ids=["followed by nothing", "met where it stays", "not met", "a cone about other axes"],
)
def test_limits_that_the_joint_cannot_have_are_reported(first, second, limits, lost):
    pair = Pair()
    pair.mate("a", *first)
    pair.mate("b", *second, limits=limits)
    made, codes = pair.combined()
    assert codes == ["I-COMPOSED", *(["W-LIMIT-LOST"] if lost else [])]
    assert (made.mates[0].limits or {}) == {}


def test_limits_that_exclude_each_other_are_reported():
    pair = Pair()
    pair.mate("a", "REVOLUTE", frame(), limits={"limitAxialZMin": -2.0, "limitAxialZMax": -1.0})
    pair.mate("b", "REVOLUTE", frame(), limits={"limitAxialZMin": 1.0, "limitAxialZMax": 2.0})
    assert pair.combined()[1] == ["I-COMPOSED", "W-LIMIT-LOST"]


def test_the_narrower_cone_of_two_balls_in_one_place_holds():
    pair = Pair()
    pair.mate("a", "BALL", frame(), (1, 0.1, 0, 0), limits={"limitEulerConeAngleMax": 0.9})
    pair.mate("b", "BALL", frame(Z, spin=1.0), (1, 0.1, 0, 0), limits={"limitEulerConeAngleMax": 0.4})
    first, other = (m.entities[0].occurrence_from_frame for m in pair.mates)
    assert not np.allclose(first, other)
    # The same axes on both bodies, so the same cone, whatever the frames' turn about them.
    pair.mates[1] = replace(pair.mates[1], entities=tuple(
        replace(entity, occurrence_from_frame=frozen(entity.occurrence_from_frame @ frame(Z, spin=0.3)))
        for entity in pair.mates[0].entities
    ))  # fmt: skip
    assert limits_of(pair.only()) == {"limitEulerConeAngleMax": 0.4}


def test_an_absorbed_mate_names_the_coordinate_that_moves_it():
    pair = Pair()
    hinge = pair.mate("a", "REVOLUTE", frame(), 0.3)
    other = pair.mate("b", "CYLINDRICAL", frame(-Z), 0.1, 0.3)
    made, _ = pair.combined()
    assert made.absorbed == {other.ref.key: Absorbed(hinge.ref.key, {"_turn": ("", -1.0)})}
    assert made.absorbed[other.ref.key].sign == -1
    pair = Pair()
    planar = pair.mate("a", "PLANAR", frame(), 0.1, 0.2, 0.3)
    ball = pair.mate("b", "BALL", frame(X), (1, 2, 3, 4))
    assert pair.combined()[0].absorbed == {
        planar.ref.key: Absorbed(planar.ref.key, {"_turn": ("", 1.0)}),
        ball.ref.key: Absorbed(planar.ref.key, {}),
    }


def test_a_gear_on_an_absorbed_hinge_turns_the_other(kit):
    """At zero, where no pose tells the sign, and with the second hinge drawn against the first."""
    base, door, wheel = kit.based("Door", "Wheel")
    kit.root.revolute("A", (door, np.eye(4)), (base, np.eye(4)))
    second = kit.root.revolute("B", (base, shift(0, 0, 1)), (door, shift(0, 0, 1)), redundant=True)
    gear = kit.root.revolute("C", (wheel, np.eye(4)), (base, shift(1, 0, 0)))
    kit.root.gear("Gear 1", second, gear, ratio=3.0)
    (relation,) = robot_of(kit.document).relations
    assert (relation.driver, relation.follower, relation.multiplier) == ("a", "c", 3.0)


AT = (0.1, 0.2, 0.3)


@pytest.mark.parametrize(
    ("first", "second", "entity"),
    [
        (("PLANAR", frame(Z, AT), 0.2, 0.1, 0.3), ("PARALLEL", frame(X, AT), 0.2, 0.1, 0.3, 0.4), ONE),
        (("PARALLEL", frame(Z, AT), 0.2, 0.1, 0.3), ("PARALLEL", frame(X, AT), 0.2, 0.1, 0.3, 0.4), ONE),
        (("PIN_SLOT", frame(Z, AT), 0.2, 0.1), ("CYLINDRICAL", frame(X, AT), 0.2, 0.1), ONE),
        (("PIN_SLOT", frame(Z, AT), 0.2, 0.1), ("REVOLUTE", frame(X, AT), 0.2), ONE),
        # Beside each other two pins in slots even span the same twists, but only at this pose.
        (("PIN_SLOT", frame(), 0.0, 0.0), ("PIN_SLOT", shift(0, 0.4, 0), 0.0, 0.0), ONE),
        (("PIN_SLOT", frame(), 0.0, 0.0), ("PIN_SLOT", frame(Z, spin=0.3), 0.0, 0.0), ONE),
        (("PIN_SLOT", frame(), 0.0, 0.0), ("PIN_SLOT", frame(), 0.0, 0.0), OTHER),
    ],
)
def test_a_motion_of_no_mate_is_left_as_it_is(first, second, entity):
    pair = Pair()
    pair.mate("a", *first)
    pair.mate("b", *second, first=entity)
    assert pair.combined() == (CombinedMates(tuple(pair.mates), (), {}), [])


def test_a_mate_that_the_saved_pose_does_not_meet_is_left():
    pair = Pair()
    pair.mate("a", "REVOLUTE", frame())
    pair.drawn("b", "REVOLUTE", shift(0, 0, 1e-4), frame())
    assert pair.combined() == (CombinedMates(tuple(pair.mates), (), {}), [])


def test_mates_of_unknown_types_and_bodies_are_passed_on():
    pair = Pair()
    pair.mate("a", "REVOLUTE", frame())
    unknown = pair.mate("b", "REVOLUTE", frame())
    pair.mates[1] = replace(unknown, ref=replace(unknown.ref, type="WIDTH"))
    side = unknown.entities[0]
    pair.mates.append(replace(unknown, title="c", entities=(side, side)))
    pair.mates.append(replace(unknown, title="d", entities=(Entity((), frozen(np.eye(4))), side)))
    assert set(pair.combined()[0].mates) == set(pair.mates)
