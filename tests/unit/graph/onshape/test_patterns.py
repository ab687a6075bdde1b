"""Patterns and mirrors: the joints of the copies, against the local Onshape's own kinematics."""

from dataclasses import replace

import numpy as np
import orjson
import pytest
from hypothesis import given, settings

from linkwright.stages.graph.onshape.bodies import find_bodies
from linkwright.stages.graph.onshape.definition import read_assembly
from linkwright.stages.graph.onshape.mass.part_solids import PartSolids
from linkwright.stages.graph.onshape.patterns.instances import with_copies
from linkwright.stages.graph.section import DepthSection, GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.dofs import LimitOrigin
from linkwright.stages.robot.model.poses import inverse
from tests.fake_onshape.definition import definition
from tests.fake_onshape.frames import frame, turn
from tests.fake_onshape.random_document import documents
from tests.support.building import bundle_of
from tests.support.kit import SIDE, TOP
from tests.support.patterned import (
    PLANE,
    bodies_of,
    codes,
    copied,
    copied_joint,
    copies,
    displacement,
    draw,
    drawn,
    mated,
    moves_right,
    wheeled,
)
from tests.support.reported import reports

KINDS = {
    "revolute": (0.4, (1.3,)),
    "slider": (0.04, (0.11,)),
    "cylindrical": ((0.02, 0.3), (0.07, -0.9)),
    "pin_slot": ((0.02, 0.3), (0.05, 1.1)),
    "planar": ((0.01, 0.02, 0.3), (0.05, -0.03, 1.2)),
    "parallel": ((0.01, 0.02, 0.03, 0.3), (0.05, -0.03, 0.02, -1.2)),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("how", ["mirror", "pattern"])
def test_a_copys_joint_moves_it_as_the_seeds_moves_the_seed(kit, kind, how):
    saved, q = KINDS[kind]
    _, arm = draw(kit, kind, saved)
    if how == "mirror":
        (copy,) = kit.root.mirror("Image", [arm], PLANE)
    else:
        ((copy,),) = kit.root.pattern("Row", [arm], [turn((0, 0, 1), 1.0, (0.5, 0, 0))])
    assembly, log = drawn(kit)
    seed, mate = assembly.mates
    poses = kit.document.truth.poses()
    motion = poses[copy.path] @ inverse(poses[arm.path])
    assert np.linalg.det(motion) == pytest.approx(-1 if how == "mirror" else 1)
    moved = displacement(assembly, seed, *q)
    assert np.abs(displacement(assembly, mate, *q) - motion @ moved @ inverse(motion)).max() < 1e-12
    moves_right(kit, assembly, mate, copy.path, copied_joint(kit), *q)
    assert codes(log) == ["I-PATTERN"]


def test_a_mirrored_ball_is_the_image_at_the_mirrored_turn(kit):
    """Its mate frames have z turned round, so x and y of a rotation's axis change sign."""
    _, arm = draw(kit, "ball", (0.9, 0.1, -0.3, 0.2))
    (image,) = kit.root.mirror("Image", [arm], PLANE)
    assembly, _ = drawn(kit)
    seed, mate = assembly.mates
    quat = (0.5, -0.5, 0.1, 0.7)
    turned, mirrored = (tuple(np.array(q) / np.linalg.norm(quat)) for q in (quat, (0.5, 0.5, -0.1, 0.7)))
    poses = kit.document.truth.poses()
    reflection = poses[image.path] @ inverse(poses[arm.path])
    moved = reflection @ displacement(assembly, seed, turned) @ inverse(reflection)
    assert np.abs(displacement(assembly, mate, mirrored) - moved).max() < 1e-12
    moves_right(kit, assembly, mate, image.path, copied_joint(kit), mirrored)


def test_copies_are_numbered_as_instances_and_keep_limits(kit):
    _, arm = draw(kit, "revolute", 0.2, limits=(-0.5, 0.7))
    (made,) = kit.root.pattern("Row", [arm], [frame((0.1 * n, 0, 0)) for n in (1, 2, 3)])
    assembly, log = drawn(kit)
    names = {mate.ref.copy: mate.ref.name for mate in copies(assembly)}
    assert [names[copy.last.id] for copy in made] == [f"Joint <{n}>" for n in (2, 3, 4)]
    assert len({mate.key for mate in assembly.mates}) == 4
    assert all(mate.limits == assembly.mates[0].limits for mate in assembly.mates)
    assert log.notes[0].message.startswith("3 joints copied for 3 instances")
    bodies = bodies_of(assembly, log)
    assert (len(bodies.members), len(bodies.moving)) == (5, 4)


def test_copies_know_why_the_limits_of_their_seed_are_unknown(kit):
    _, arm = draw(kit, "revolute", 0.2)
    kit.root.pattern("Row", [arm], [frame((0.1, 0, 0))])
    assembly = read_assembly(orjson.dumps(definition(kit.document)))
    origin = LimitOrigin("limitAxialZMax is '#lost', which has no value")
    assembly = replace(assembly, mates=[replace(assembly.mates[0], limit_origin=origin)])
    solids = PartSolids(assembly, bundle_of(kit.document))
    (copy,) = copies(with_copies(assembly, GraphSections(), solids, Diagnostics()))
    assert copy.limit_origin == origin


def handed(kit, *places):
    """An arm with a hand that slides on it, and their pattern."""
    base, arm = draw(kit, "revolute", 0.4)
    hand = kit.place("Hand")
    kit.root.slider("Grip", (hand, TOP), (arm, SIDE), value=0.02)
    return base, *kit.root.pattern("Row", [arm, hand], list(places))


def test_a_mate_between_two_seeds_joins_their_copies(kit):
    base, arms, hands = handed(kit, frame((0.2, 0, 0)), frame((0.4, 0, 0)))
    assembly, log = drawn(kit)
    sliders = [mate for mate in copies(assembly) if mate.ref.type == "SLIDER"]
    joined = {frozenset(entity.path for entity in mate.entities) for mate in sliders}
    assert joined == {frozenset({a.path, h.path}) for a, h in zip(arms, hands, strict=True)}
    assert len(copies(assembly)) == 4
    assert [note.message[:32] for note in log.notes] == ["4 joints copied for 4 instances,"]
    for mate in copies(assembly):
        off = displacement(assembly, mate, {"REVOLUTE": 0.4, "SLIDER": 0.02}[mate.ref.type])
        assert np.abs(off - np.eye(4)).max() < 1e-12, "met at the saved pose, at the seed's value"
    assert base.path in {entity.path for mate in copies(assembly) for entity in mate.entities}


def test_a_copy_of_a_copy_has_its_joints_too(kit):
    _, arm = draw(kit, "revolute", 0.4)
    ((second,),) = kit.root.pattern("Row", [arm], [frame((0.2, 0, 0))])
    (third,) = kit.root.mirror("Image", [second], PLANE)
    assembly, log = drawn(kit)
    mates = {mate.ref.copy: mate for mate in copies(assembly)}
    assert mates.keys() == {second.last.id, third.last.id}
    moves_right(kit, assembly, mates[third.last.id], third.path, copied_joint(kit, 2), 1.2)
    assert codes(log) == ["I-PATTERN", "I-PATTERN"]


def steered(kit, whole=False):
    """A corner with a wheel, hung on a base as a whole or by its hub, and its mirror image."""
    corner, hub, wheel = wheeled(kit)
    base = kit.place("Base", fixed=True)
    path = kit.root.add(corner)
    kit.root.revolute("Steer", (path if whole else path / hub, SIDE), (base, TOP), value=0.5)
    (image,) = kit.root.mirror("Image", [path], PLANE)
    return base, path, image, hub, wheel


@pytest.mark.parametrize("whole", [True, False])
def test_a_mirrored_sub_assembly_hangs_by_copied_mates(kit, whole):
    _, corner, image, _, wheel = steered(kit, whole)
    assembly, log = drawn(kit)
    bodies = bodies_of(assembly, log)
    assert len(bodies.members) == 5
    mates = {(mate.ref.owner, mate.ref.name): mate for mate in bodies.moving}
    assert set(mates) == {((), "Steer"), ((), "Steer <2>"), (corner.path, "Spin"), (image.path, "Spin")}
    (joint,) = (joint.name for joint in kit.document.truth.joints if joint.owner == image.path)
    moves_right(kit, assembly, mates[image.path, "Spin"], (image / wheel).path, joint, 1.4)
    moves_right(kit, assembly, mates[(), "Steer <2>"], (image / wheel).path, copied_joint(kit), -0.8)
    assert codes(log) == ["I-PATTERN"]


def test_a_copy_with_mates_of_its_own_gets_none(kit):
    _, arm = draw(kit, "revolute", 0.4)
    ((own, free),) = kit.root.pattern("Row", [arm], [frame((0.2, 0, 0)), frame((0.4, 0, 0))])
    assembly, _ = drawn(kit, edit=mated(own.path))
    assert [mate.ref.copy for mate in copies(assembly)] == [free.last.id]
    assert sorted(mate.ref.name for mate in assembly.mates) == ["Joint", "Joint <3>", "Own"]


def test_mirror_weld_fastens_copies_and_makes_them_rigid_inside(kit):
    base, corner, image, hub, wheel = steered(kit)
    assembly, log = drawn(kit, mirror="weld")
    (weld,) = copies(assembly)
    first, second = (assembly.world_from(entity) for entity in weld.entities)
    assert weld.ref.type == "FASTENED"
    assert np.abs(first - second).max() < 1e-12
    bodies = bodies_of(assembly, log)
    groups = ((base, image / hub, image / wheel), (corner / hub,), (corner / wheel,))
    members = {frozenset(paths) for paths in bodies.members}
    assert members == {frozenset(place.path for place in group) for group in groups}
    assert sorted(mate.ref.name for mate in bodies.moving) == ["Spin", "Steer"]
    assert codes(log) == ["I-PATTERN", "I-RIGID"]
    assert "mirror: joints" in log.notes[1].hint
    bodies = bodies_of(assembly, log, depth=DepthSection(flexible=("Corner <2>",)))
    assert sorted(mate.title for mate in bodies.moving) == ["Corner <1>/Spin", "Corner <2>/Spin", "Steer"]


def test_mirror_weld_does_not_freeze_a_copy_between_two_mates(kit):
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


def test_relations_of_seeds_are_not_copied_and_that_is_reported(kit):
    base, arm, other, third = kit.based("Arm", "Other", "Third")
    joint = kit.root.revolute("Joint", (arm, TOP), (base, SIDE))
    driven = kit.root.revolute("Driven", (other, TOP), (base, TOP))
    free = kit.root.revolute("Free", (third, TOP), (base, frame((1, 0, 0))))
    kit.root.gear("Gear", joint, driven)
    kit.root.gear("Far gear", driven, free)
    kit.root.pattern("Row", [arm], [frame((0.2, 0, 0))])
    assembly, log = drawn(kit)
    assert reports(log) == [("W-PATTERN-RELATION", "Gear"), ("I-PATTERN", "Row")]
    assert len(assembly.relations) == 2


def _without(ident):
    def edit(root):
        for instance in root["instances"]:
            if instance["id"] == ident:
                instance["suppressed"] = True

    return edit


def test_suppressed_copies_are_absent_and_seeds_reported(kit):
    _, arm = draw(kit, "revolute", 0.4)
    ((second, third),) = kit.root.pattern("Row", [arm], [frame((0.2, 0, 0)), frame((0.4, 0, 0))])
    assembly, log = drawn(kit, edit=_without(second.last.id))
    assert [(mate.ref.copy, mate.ref.name) for mate in copies(assembly)] == [(third.last.id, "Joint <3>")]
    assert codes(log) == ["I-PATTERN"]
    assembly, log = drawn(kit, edit=_without(arm.last.id))
    assert (copies(assembly), codes(log)) == ([], ["W-PATTERN"])
    assert "Arm <2>, Arm <3>" in log.notes[0].message


def test_a_mate_of_two_seeds_waits_for_both_copies(kit):
    _, (second,), (lost,) = handed(kit, frame((0.2, 0, 0)))
    assembly, _ = drawn(kit, edit=_without(lost.last.id))
    assert [(mate.ref.name, mate.ref.copy) for mate in copies(assembly)] == [("Joint <2>", second.last.id)]


def _loosely(root):
    """The same pattern in every way that the API may send, and some that lack things."""
    (pattern,) = root["patterns"]
    ((seed, ids),) = pattern["seedToPatternInstances"].items()
    children = [
        *({"instanceIds": ids, "seedOccurrence": seed}, {"instanceIds": None, "seedOccurrence": "x"}, {})
    ]
    more = [{"id": "y"}, {"id": "x", "suppressed": True}]
    root["parametricInstances"] = [{"id": "z", "children": children}, *more]
    root["patterns"] = [pattern, {"type": "UNKNOWN"}, {"id": "q", "seedToPatternInstances": {"gone": ["no"]}}]


def test_a_copy_counts_once_and_missing_keys_do_not_matter(kit):
    _, arm = draw(kit, "revolute", 0.4)
    kit.root.pattern("Row", [arm], [frame((0.2, 0, 0))])
    assembly, log = drawn(kit, edit=_loosely)
    assert [mate.ref.name for mate in copies(assembly)] == ["Joint <2>"]
    assert codes(log) == ["I-PATTERN"]


def test_mirrors_of_other_parts_and_of_single_sides_are_reported(kit):
    _, arm = draw(kit, "revolute", 0.4)
    (image,) = kit.root.mirror("Image", [arm], PLANE)

    def derived(root):
        next(i for i in root["instances"] if i["id"] == image.last.id)["partId"] = "Other"

    assembly, log = drawn(kit, edit=derived)
    assert (copies(assembly), reports(log)) == ([], [("W-PATTERN", "Image")])
    assembly, log = drawn(kit, edit=mated(image.path))
    bodies_of(assembly, log)
    assert reports(log) == [("W-MIRROR", "Own")]


@settings(max_examples=15)
@given(documents(everything=True))
def test_any_assembly_has_the_bodies_and_mates_of_its_document(document):
    log = Diagnostics()
    assembly = copied(definition(document), document, GraphSections(), log)
    bodies, truth = find_bodies(assembly, GraphSections(), log), document.truth
    parts = {body.parts for body in truth.bodies if body.parts}
    assert {frozenset(paths) for paths in bodies.members if paths} == parts
    drawn = [e for e in (*truth.joints, *truth.closings, *truth.redundant) if e.type != "FASTENED"]
    keys = {(edge.owner, edge.feature, edge.onto[0] if edge.onto else "") for edge in drawn}
    assert {mate.key for mate in bodies.moving} == keys
    assert not log.problems
