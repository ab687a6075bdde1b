"""Patterns and mirrors: the joints of the copies, against the local Onshape's own kinematics."""

import math
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given, settings

from linkwright.stages.graph.onshape.assembly import Mate
from linkwright.stages.graph.onshape.bodies import find_bodies
from linkwright.stages.graph.section import DepthSection, GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import inverse
from tests.fake_onshape.definition import definition
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame, turn
from tests.fake_onshape.random_document import documents
from tests.support.kit import SIDE, TOP, Kit
from tests.support.patterned import (
    PLANE,
    bodies_of,
    codes,
    copied,
    copies,
    displacement,
    draw,
    drawn,
    expected,
    mated,
    wheeled,
)

KINDS: dict[str, tuple[object, tuple[float, ...]]] = {
    "revolute": (0.4, (1.3,)),
    "slider": (0.04, (0.11,)),
    "cylindrical": ((0.02, 0.3), (0.07, -0.9)),
    "pin_slot": ((0.02, 0.3), (0.05, 1.1)),
    "planar": ((0.01, 0.02, 0.3), (0.05, -0.03, 1.2)),
    "parallel": ((0.01, 0.02, 0.03, 0.3), (0.05, -0.03, 0.02, -1.2)),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("how", ["mirror", "pattern"])
def test_a_copys_joint_moves_it_as_its_seeds_moves_the_seed_moved_or_mirrored(kit, kind, how) -> None:
    saved, q = KINDS[kind]
    _, arm = draw(kit, kind, saved)
    if how == "mirror":
        (copy,) = kit.root.mirror("Image", [arm], PLANE)
    else:
        ((copy,),) = kit.root.pattern("Row", [arm], [turn((0, 0, 1), 1.0, (0.5, 0, 0))])
    assembly, log = drawn(kit)
    (mate,) = copies(assembly)
    poses = kit.document.truth.poses
    motion = poses()[copy.path] @ inverse(poses()[arm.path])
    assert np.linalg.det(motion) == pytest.approx(-1 if how == "mirror" else 1)
    (seed,) = (mate for mate in assembly.mates if not mate.ref.copy)
    moved = displacement(assembly, seed, *q)
    assert np.abs(displacement(assembly, mate, *q) - motion @ moved @ inverse(motion)).max() < 1e-12
    (joint,) = (joint for joint in kit.document.truth.joints if joint.copies)
    truth = expected(kit, copy.path, {joint.name: q if len(q) > 1 else q[0]})
    assert np.abs(displacement(assembly, mate, *q) - truth).max() < 1e-12
    assert codes(log) == ["I-PATTERN"]
    assert not [told for told in codes(log) if told == "W-MIRROR"]


def test_a_mirrored_ball_is_the_mirror_image_at_the_mirrored_turn(kit: Kit) -> None:
    """Its mate frames have z turned round, so x and y of a rotation's axis change sign."""
    _, arm = draw(kit, "ball", (0.9, 0.1, -0.3, 0.2))
    (image,) = kit.root.mirror("Image", [arm], PLANE)
    assembly, _ = drawn(kit)
    seed, mate = assembly.mates
    quat = (0.5, -0.5, 0.1, 0.7)
    turned, mirrored = (tuple(np.array(q) / np.linalg.norm(quat)) for q in (quat, (0.5, 0.5, -0.1, 0.7)))
    reflection = kit.document.truth.poses()[image.path] @ inverse(kit.document.truth.poses()[arm.path])
    moved = reflection @ displacement(assembly, seed, turned) @ inverse(reflection)
    assert np.abs(displacement(assembly, mate, mirrored) - moved).max() < 1e-12
    (joint,) = (joint for joint in kit.document.truth.joints if joint.copies)
    truth = expected(kit, image.path, {joint.name: mirrored})
    assert np.abs(displacement(assembly, mate, mirrored) - truth).max() < 1e-12


def test_copies_are_numbered_as_their_instances_and_keep_the_limits(kit: Kit) -> None:
    _, arm = draw(kit, "revolute", 0.2, limits=(-0.5, 0.7))
    (made,) = kit.root.pattern("Row", [arm], [frame((0.1 * n, 0, 0)) for n in (1, 2, 3)])
    assembly, log = drawn(kit)
    found = {mate.ref.copy: mate for mate in copies(assembly)}
    assert [found[copy.last.id].ref.name for copy in made] == [f"Joint <{n}>" for n in (2, 3, 4)]
    assert len({mate.key for mate in assembly.mates}) == 4
    assert all(mate.limits == assembly.mates[0].limits for mate in assembly.mates)
    (told,) = log.found
    assert told.message.startswith("3 joints copied for 3 instances")
    bodies = bodies_of(assembly, log)
    assert len(bodies.members) == 5
    assert len(bodies.moving) == 4


def test_a_mate_between_two_seeds_joins_their_copies(kit: Kit) -> None:
    base, arm = draw(kit, "revolute", 0.4)
    hand = kit.place("Hand")
    kit.root.slider("Grip", (hand, TOP), (arm, SIDE), value=0.02)
    (arms, hands) = kit.root.pattern("Row", [arm, hand], [frame((0.2, 0, 0)), frame((0.4, 0, 0))])
    assembly, log = drawn(kit)
    joined = {
        frozenset(entity.path for entity in mate.entities)
        for mate in copies(assembly)
        if mate.ref.type == "SLIDER"
    }
    assert joined == {frozenset({a.path, h.path}) for a, h in zip(arms, hands, strict=True)}
    assert len(copies(assembly)) == 4
    assert [told.message[:32] for told in log.found] == ["4 joints copied for 4 instances,"]
    for mate in copies(assembly):
        values = {"REVOLUTE": 0.4, "SLIDER": 0.02}
        off = displacement(assembly, mate, values[mate.ref.type])
        assert np.abs(off - np.eye(4)).max() < 1e-12, "met at the saved pose, at the seed's value"
    assert base.path in {entity.path for mate in copies(assembly) for entity in mate.entities}


def test_a_copy_of_a_copy_has_its_joints_too(kit: Kit) -> None:
    _, arm = draw(kit, "revolute", 0.4)
    ((second,),) = kit.root.pattern("Row", [arm], [frame((0.2, 0, 0))])
    (third,) = kit.root.mirror("Image", [second], PLANE)
    assembly, log = drawn(kit)
    assert {mate.ref.copy for mate in copies(assembly)} == {second.last.id, third.last.id}
    (mate,) = (mate for mate in copies(assembly) if mate.ref.copy == third.last.id)
    (joint,) = (joint for joint in kit.document.truth.joints if len(joint.copies) == 2)
    assert (
        np.abs(displacement(assembly, mate, 1.2) - expected(kit, third.path, {joint.name: 1.2})).max() < 1e-12
    )
    assert codes(log) == ["I-PATTERN", "I-PATTERN"]


@pytest.mark.parametrize("whole", [True, False])
def test_a_mirrored_sub_assembly_moves_inside_by_its_own_mates_and_hangs_by_its_copied_ones(
    kit, whole
) -> None:
    corner, hub, wheel = wheeled(kit)
    base = kit.place("Base", fixed=True)
    one = kit.root.add(corner)
    kit.root.revolute("Steer", (one if whole else one / hub, SIDE), (base, TOP), value=0.5)
    (image,) = kit.root.mirror("Image", [one], PLANE)
    assembly, log = drawn(kit)
    bodies = bodies_of(assembly, log)
    assert len(bodies.members) == 5
    mates = {(mate.ref.owner, mate.ref.name): mate for mate in bodies.moving}
    assert set(mates) == {
        ((), "Steer"), ((), "Steer <2>"), (one.path, "Spin"), (image.path, "Spin"),
    }  # fmt: skip
    spin = displacement(assembly, mates[image.path, "Spin"], 1.4)
    (joint,) = (j for j in kit.document.truth.joints if j.owner == image.path)
    assert np.abs(spin - expected(kit, (image / wheel).path, {joint.name: 1.4})).max() < 1e-12
    (steer,) = (j for j in kit.document.truth.joints if j.copies)
    turned = displacement(assembly, mates[(), "Steer <2>"], -0.8)
    assert np.abs(turned - expected(kit, (image / wheel).path, {steer.name: -0.8})).max() < 1e-12
    assert codes(log) == ["I-PATTERN"]


def test_patterns_inside_a_sub_assembly_act_in_each_of_its_places(kit: Kit) -> None:
    cart = kit.document.assembly("Cart")
    frame_part, wheel = kit.place("Frame", cart), kit.place("Wheel", cart)
    cart.revolute("Spin", (wheel, TOP), (frame_part, SIDE), value=0.3)
    cart.pattern("Row", [wheel], [frame((0.2, 0, 0))])
    base = kit.place("Base", fixed=True)
    for number, offset in enumerate((0.0, 1.0)):
        one = kit.root.add(cart)
        kit.root.slider(f"Rail {number}", (one / frame_part, TOP), (base, frame((0, offset, 0))))
    assembly, log = drawn(kit)
    assert len(copies(assembly)) == 2
    for mate in copies(assembly):
        assert np.abs(displacement(assembly, mate, 0.3) - np.eye(4)).max() < 1e-12
    assert len(bodies_of(assembly, log).moving) == 6


def test_copies_join_the_groups_of_their_seeds_each_at_its_own(kit: Kit) -> None:
    base, arm = draw(kit, "revolute", 0.4)
    bolt, nut = kit.place("Bolt"), kit.place("Nut")
    kit.root.group("Glue", [(base, np.eye(4)), (bolt, TOP)])
    kit.root.group("Grip", [(arm, np.eye(4)), (nut, TOP)])
    ((second_bolt,),) = kit.root.pattern("Bolts", [bolt], [frame((0.1, 0, 0))])
    ((second_arm,), (second_nut,)) = kit.root.pattern("Arms", [arm, nut], [frame((0.2, 0, 0))])
    assembly, log = drawn(kit)
    found = {frozenset(paths) for paths in bodies_of(assembly, log).members}
    assert found == {
        frozenset({base.path, bolt.path, second_bolt.path}),
        frozenset({arm.path, nut.path}),
        frozenset({second_arm.path, second_nut.path}),
    }


def test_a_copy_with_mates_of_its_own_gets_none(kit: Kit) -> None:
    _, arm = draw(kit, "revolute", 0.4)
    ((own, free),) = kit.root.pattern("Row", [arm], [frame((0.2, 0, 0)), frame((0.4, 0, 0))])
    assembly, _ = drawn(kit, edit=mated(own.path))
    assert [mate.ref.copy for mate in copies(assembly)] == [free.last.id]
    assert sorted(mate.ref.name for mate in assembly.mates) == ["Joint", "Joint <3>", "Own"]


def test_mirror_weld_fastens_the_copies_where_they_are_and_makes_them_rigid_inside(kit: Kit) -> None:
    corner, hub, wheel = wheeled(kit)
    base = kit.place("Base", fixed=True)
    one = kit.root.add(corner)
    kit.root.revolute("Steer", (one / hub, SIDE), (base, TOP), value=0.5)
    (image,) = kit.root.mirror("Image", [one], PLANE)
    assembly, log = drawn(kit, mirror="weld")
    (weld,) = copies(assembly)
    first, second = (assembly.world_from(entity) for entity in weld.entities)
    assert weld.ref.type == "FASTENED"
    assert np.abs(first - second).max() < 1e-12
    bodies = bodies_of(assembly, log)
    held = {base.path, (image / hub).path, (image / wheel).path}
    assert {frozenset(paths) for paths in bodies.members} == {
        frozenset(held), frozenset({(one / hub).path}), frozenset({(one / wheel).path}),
    }  # fmt: skip
    assert sorted(mate.ref.name for mate in bodies.moving) == ["Spin", "Steer"]
    assert codes(log) == ["I-PATTERN", "I-RIGID"]
    assert "mirror: joints" in log.found[1].hint


def test_mirror_weld_does_not_freeze_what_lies_between_two_mates_of_a_copy(kit: Kit) -> None:
    base, arm = draw(kit, "revolute", 0.4)
    rod = kit.place("Rod")
    kit.root.revolute("Foot", (rod, TOP), (base, TOP), value=0.1)
    kit.root.revolute("Head", (rod, SIDE), (arm, SIDE), closing=True)
    (image,) = kit.root.mirror("Image", [rod], PLANE)
    assembly, log = drawn(kit, mirror="weld")
    assert [mate.title for mate in copies(assembly)] == ["Foot <2>"]
    bodies = bodies_of(assembly, log)
    assert {mate.title for mate in bodies.moving} == {"Joint", "Foot", "Head"}
    assert bodies.of[image.path] == bodies.of[base.path]
    assert codes(log) == ["I-PATTERN"]


def test_relations_of_seeds_are_not_copied_and_that_is_reported(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    other = kit.place("Other")
    joint = kit.root.revolute("Joint", (arm, TOP), (base, SIDE))
    driven = kit.root.revolute("Driven", (other, TOP), (base, TOP))
    free = kit.root.revolute("Free", (kit.place("Third"), TOP), (base, frame((1, 0, 0))))
    kit.root.gear("Gear", joint, driven)
    kit.root.gear("Far gear", driven, free)
    kit.root.pattern("Row", [arm], [frame((0.2, 0, 0))])
    assembly, log = drawn(kit)
    told = [(found.code, found.where) for found in log.found]
    assert told == [("W-PATTERN-RELATION", "Gear"), ("I-PATTERN", "Row")]
    assert len(assembly.relations) == 2


def _without(ident: str):
    def edit(root: dict) -> None:
        for instance in root["instances"]:
            if instance["id"] == ident:
                instance["suppressed"] = True

    return edit


def test_a_suppressed_copy_is_absent_and_a_suppressed_seed_is_reported(kit: Kit) -> None:
    _, arm = draw(kit, "revolute", 0.4)
    ((second, third),) = kit.root.pattern("Row", [arm], [frame((0.2, 0, 0)), frame((0.4, 0, 0))])
    assembly, log = drawn(kit, edit=_without(second.last.id))
    assert [mate.ref.copy for mate in copies(assembly)] == [third.last.id]
    assert copies(assembly)[0].ref.name == "Joint <3>"
    assert codes(log) == ["I-PATTERN"]
    assembly, log = drawn(kit, edit=_without(arm.last.id))
    assert not copies(assembly)
    assert codes(log) == ["W-PATTERN"]
    assert "Arm <2>, Arm <3>" in log.found[0].message


def test_a_mate_of_two_seeds_waits_for_both_copies(kit: Kit) -> None:
    _, arm = draw(kit, "revolute", 0.4)
    hand = kit.place("Hand")
    kit.root.slider("Grip", (hand, TOP), (arm, SIDE), value=0.02)
    ((second,), (lost,)) = kit.root.pattern("Row", [arm, hand], [frame((0.2, 0, 0))])
    assembly, _ = drawn(kit, edit=_without(lost.last.id))
    assert [(mate.ref.name, mate.ref.copy) for mate in copies(assembly)] == [("Joint <2>", second.last.id)]


def _loosely(root: dict) -> None:
    """The same pattern in every way that the API may send, and some that lack things."""
    (pattern,) = root["patterns"]
    ((seed, ids),) = pattern["seedToPatternInstances"].items()
    children = [
        {"instanceIds": ids, "seedOccurrence": seed},
        {"instanceIds": None, "seedOccurrence": "x"},
        {},
    ]
    root["parametricInstances"] = [
        {"id": "z", "children": children},
        {"id": "y"},
        {"id": "x", "suppressed": True},
    ]
    root["patterns"] = [pattern, {"type": "UNKNOWN"}, {"id": "q", "seedToPatternInstances": {"gone": ["no"]}}]


def test_a_copy_that_is_listed_twice_counts_once_and_missing_keys_do_not_matter(kit: Kit) -> None:
    _, arm = draw(kit, "revolute", 0.4)
    kit.root.pattern("Row", [arm], [frame((0.2, 0, 0))])
    assembly, log = drawn(kit, edit=_loosely)
    assert [mate.ref.name for mate in copies(assembly)] == ["Joint <2>"]
    assert codes(log) == ["I-PATTERN"]


def test_a_mirror_that_made_another_part_is_reported(kit: Kit) -> None:
    _, arm = draw(kit, "revolute", 0.4)
    (image,) = kit.root.mirror("Image", [arm], PLANE)

    def derived(root: dict) -> None:
        next(i for i in root["instances"] if i["id"] == image.last.id)["partId"] = "Other"

    assembly, log = drawn(kit, edit=derived)
    assert not copies(assembly)
    assert [(told.code, told.where) for told in log.found] == [("W-PATTERN", "Image")]


def test_a_mate_with_one_mirrored_side_is_reported(kit: Kit) -> None:
    _, arm = draw(kit, "revolute", 0.4)
    (image,) = kit.root.mirror("Image", [arm], PLANE)
    assembly, log = drawn(kit, edit=mated(image.path))
    bodies_of(assembly, log)
    assert [(told.code, told.where) for told in log.found] == [("W-MIRROR", "Own")]


def test_the_order_of_a_reply_changes_nothing(kit: Kit) -> None:
    _, arm = draw(kit, "revolute", 0.4)
    hand = kit.place("Hand")
    kit.root.revolute("Wrist", (hand, TOP), (arm, SIDE))
    kit.root.pattern("Row", [arm, hand], [frame((0.2, 0, 0)), frame((0.4, 0, 0))])
    kit.root.mirror("Image", [arm, hand], PLANE)

    def told(mates: Iterable[Mate]) -> list[object]:
        return sorted((m.key, m.title, [e.path for e in m.entities]) for m in mates)

    plain, log = drawn(kit)
    for seed in range(3):
        shuffled, again = drawn(kit, shuffle=seed)
        assert told(shuffled.mates) == told(plain.mates)
        assert codes(again) == codes(log)


def test_depth_keeps_a_mirrored_copy_moving_where_it_is_named_flexible(kit: Kit) -> None:
    corner, hub, _ = wheeled(kit)
    base = kit.place("Base", fixed=True)
    one = kit.root.add(corner)
    kit.root.revolute("Steer", (one / hub, SIDE), (base, TOP), value=math.pi / 6)
    kit.root.mirror("Image", [one], PLANE)
    assembly, log = drawn(kit, mirror="weld")
    bodies = bodies_of(assembly, log, depth=DepthSection(flexible=("Corner <2>",)))
    assert sorted(mate.title for mate in bodies.moving) == ["Corner <1>/Spin", "Corner <2>/Spin", "Steer"]


@settings(max_examples=25)
@given(documents(everything=True))
def test_any_assembly_has_the_bodies_and_the_mates_that_its_author_knows_of(document: Document) -> None:
    log = Diagnostics()
    assembly = copied(definition(document), document, GraphSections(), log)
    bodies = find_bodies(assembly, GraphSections(), log)
    truth = document.truth
    assert {frozenset(paths) for paths in bodies.members if paths} == {
        b.parts for b in truth.bodies if b.parts
    }
    drawn = [e for e in (*truth.joints, *truth.closings, *truth.redundant) if e.type != "FASTENED"]
    keys = {(edge.owner, edge.feature, edge.onto[0] if edge.onto else "") for edge in drawn}
    assert {mate.key for mate in bodies.moving} == keys
    assert not log.problems
