"""Patterns, mirrors and occurrences fixed one by one, in the documents' own kinematics."""

import math

import numpy as np
import pytest

from tests.fake_onshape.definition import definition
from tests.fake_onshape.differences import differences_hold
from tests.fake_onshape.document import ORIGIN
from tests.fake_onshape.frames import frame, inverse, product, turn
from tests.fake_onshape.mates import MIRROR
from tests.support.kit import OFF, ON, Kit

PLANE = turn((0.6, 0.0, 0.8), 0.4, (0.02, 0.3, -0.1))
REFLECTION = product(PLANE, MIRROR, inverse(PLANE))
WAY = turn((0, 0, 1), 0.8, (0.0, 0.2, 0.0))


def limb(kit: Kit, name: str = "Limb", kind: str = "cylindrical", value: object = (0.02, 0.3)):
    """A sub-assembly of three bars: one on another by a mate of this kind, and a hinge."""
    sub = kit.document.assembly(name)
    hip, shin, toe = (kit.place(f"{name} {n}", sub) for n in ("hip", "shin", "toe"))
    inner = getattr(sub, kind)("Inner", (shin, ON), (hip, OFF), value)
    toes = sub.revolute("Toes", (shin, OFF), (toe, ON), 0.2)
    return sub, (hip, shin, toe), (inner, toes)


def walker(mirror: bool, kind: str = "cylindrical", value: object = (0.02, 0.3), reverse: bool = False):
    """A fixed base with a limb on a slide, and the limb's copy: by a mirror, or by a pattern."""
    kit = Kit()
    sub, parts, mates = limb(kit, kind=kind, value=value)
    base, leg = kit.place("Base", fixed=True), kit.root.add(sub)
    ends = [(leg / parts[0], ON), (base, OFF)]
    drive = kit.root.slider("Drive", *(ends[::-1] if reverse else ends), 0.05, (-0.1, 0.2))
    if mirror:
        (copy,) = kit.root.mirror("Mirror 1", [leg], PLANE)
    else:
        ((copy,),) = kit.root.pattern("Linear 1", [leg], [WAY])
    return kit, base, leg, copy, parts, mates, drive


def value_at_copy(truth, drive, copy, leg, mates, drives, inner, toes):
    return {
        truth.joint(((), drive.id)).name: drives,
        truth.joint(((), drive.id, copy.last.id)).name: drives,
        **{(occurrence.path, mates[0].id): inner for occurrence in (leg, copy)},
        **{(occurrence.path, mates[1].id): toes for occurrence in (leg, copy)},
    }


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(
    ("kind", "values"),
    [("cylindrical", (0.04, -0.9)), ("parallel", (0.1, 0.2, 0.3, 0.4)), ("pin_slot", (0.1, 0.5))],
)
def test_at_equal_values_a_mirrored_limb_is_the_mirror_image(kind, values, reverse) -> None:
    at = tuple(0.5 * one for one in values)
    kit, _, leg, copy, parts, mates, drive = walker(True, kind, at, reverse)
    truth = kit.document.truth
    truth.check()
    for q in ({}, value_at_copy(truth, drive, copy, leg, mates, -0.07, values, 1.1)):
        poses = truth.poses(q)
        for part in parts:
            image = REFLECTION @ poses[(leg / part).path]
            assert poses[(copy / part).path] == pytest.approx(image, abs=1e-12)
            assert np.linalg.det(poses[(copy / part).path][:3, :3]) == pytest.approx(-1)
    differences_hold(truth, truth.values(), roots=(None, (copy / parts[2]).path))


def test_a_mirrored_ball_turns_about_the_mirrored_axis() -> None:
    kit, _, leg, copy, parts, mates, _ = walker(True, "ball", (0.5, 0.5, -0.5, 0.5))
    truth = kit.document.truth
    truth.check()
    w, x, y, z = value = (0.8, 0.36, -0.48, 0.0)
    mirrored = {(leg.path, mates[0].id): value, (copy.path, mates[0].id): (w, -x, -y, z)}
    poses = truth.poses(mirrored)
    for part in parts:
        image = REFLECTION @ poses[(leg / part).path]
        assert poses[(copy / part).path] == pytest.approx(image, abs=1e-12)
    differences_hold(truth, truth.values())


def test_the_mirror_of_a_mirror_is_right_handed() -> None:
    kit, base, leg, copy, parts, _, _ = walker(True)
    base.last.fixed = False
    outer = kit.document.assembly("Whole")
    kit.document.root = outer
    walk = outer.add(kit.root)
    outer.slider("Stands", (walk / base, ON), (ORIGIN, ON), 0.3)
    (image,) = outer.mirror("Again", [walk], OFF)
    truth = kit.document.truth
    truth.check()
    twice = OFF @ MIRROR @ inverse(OFF)
    poses = truth.poses()
    for part in parts:
        for limbs, sign in ((leg, -1), (copy, 1)):
            pose = poses[(image / limbs / part).path]
            assert np.linalg.det(pose[:3, :3]) == pytest.approx(sign)
            assert pose == pytest.approx(twice @ poses[(walk / limbs / part).path], abs=1e-12)


def test_copies_of_a_pattern_have_joints_of_their_own() -> None:
    kit = Kit()
    base = kit.place("Base", fixed=True)
    wheel = kit.place("Wheel")
    spin = kit.root.revolute("Spin", (wheel, ON), (base, OFF), 0.3, (-1, 2))
    turns = [turn((0, 0, 1), k * math.pi / 2) for k in (1, 2, 3)]
    (wheels,) = kit.root.pattern("Circular 1", [wheel], turns, kind="CIRCULAR")
    truth = kit.document.truth
    truth.check()
    assert [edge.name for edge in truth.joints] == ["Spin", *(f"Spin [Circular 1 {k}]" for k in (1, 2, 3))]
    assert [copy.last.name for copy in wheels] == ["Wheel <2>", "Wheel <3>", "Wheel <4>"]
    assert truth.joint(((), spin.id)) is truth.joint(((), spin.id, "")) is truth.joint("Spin")
    for copy, moved in zip(wheels, turns, strict=True):
        edge = truth.joint(((), spin.id, copy.last.id))
        assert (edge.value, edge.limits, edge.second) == (0.3, (-1, 2), base.path)
        pose = truth.poses({edge.name: -0.9})
        assert pose[copy.path] == pytest.approx(moved @ truth.poses({"Spin": -0.9})[wheel.path], abs=1e-12)
        assert pose[wheel.path] == pytest.approx(truth.poses()[wheel.path], abs=1e-12)


def test_a_mate_between_two_seeds_joins_their_copies() -> None:
    kit = Kit()
    base, arm, hand = kit.place("Base", fixed=True), kit.place("Arm"), kit.place("Hand")
    kit.root.revolute("Shoulder", (arm, ON), (base, OFF), 0.3)
    wrist = kit.root.revolute("Wrist", (hand, ON), (arm, OFF), -0.4)
    arms, hands = kit.root.pattern("Linear 1", [arm, hand], [WAY, WAY @ WAY])
    truth = kit.document.truth
    truth.check()
    edge = truth.joint(((), wrist.id, hands[1].last.id))
    assert (edge.first, edge.second) == (hands[1].path, arms[1].path)
    assert truth.joint(((), wrist.id, arms[1].last.id)) is edge
    assert len(truth.tree_joints) == 6


def test_groups_weld_the_copies_of_their_members() -> None:
    kit = Kit()
    base, one, two = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    kit.root.revolute("Turn", (one, ON), (base, OFF), 0.3)
    kit.root.group("Group", [(two, frame()), (one, frame((0.1, 0, 0)))])
    ((copy,),) = kit.root.pattern("Linear 1", [two], [WAY])
    truth = kit.document.truth
    truth.check()
    assert truth.body_of(copy.path).parts == {one.path, two.path, copy.path}


def test_records_of_patterns_and_mirrors_name_seeds_and_copies() -> None:
    kit = Kit()
    base, one = kit.place("Base", fixed=True), kit.place("One")
    kit.root.revolute("Turn", (one, ON), (base, OFF), 0.3)
    (copies,) = kit.root.pattern("Linear 1", [one], [WAY, WAY @ WAY])
    (image,) = kit.root.mirror("Mirror 1", [one], PLANE)
    root = definition(kit.document)["rootAssembly"]
    assert len(root["features"]) == 1
    (pattern,), (mirror,) = root["patterns"], root["parametricInstances"]
    assert (pattern["type"], pattern["name"], pattern["suppressed"]) == ("LINEAR", "Linear 1", False)
    assert pattern["seedToPatternInstances"] == {one.last.id: [copy.last.id for copy in copies]}
    assert mirror["type"] == "Mirror"
    assert mirror["children"] == [{"instanceIds": [image.last.id], "seedOccurrence": one.last.id}]
    transforms = {tuple(o["path"]): np.reshape(o["transform"], (4, 4)) for o in root["occurrences"]}
    assert transforms[image.path] == pytest.approx(REFLECTION @ transforms[one.path], abs=1e-12)
    assert transforms[copies[1].path] == pytest.approx(WAY @ WAY @ transforms[one.path], abs=1e-12)


def test_a_mirrored_part_weighs_as_much_the_other_way_round() -> None:
    kit, _, leg, copy, parts, _, _ = walker(True)
    truth = kit.document.truth
    one = truth.inertial([(leg / part).path for part in parts])
    two = truth.inertial([(copy / part).path for part in parts])
    flip = REFLECTION[:3, :3]
    assert two.mass == pytest.approx(one.mass)
    assert two.com == pytest.approx((REFLECTION @ [*one.com, 1])[:3])
    assert two.inertia == pytest.approx(flip @ one.inertia @ flip.T)


def test_one_occurrence_can_be_fixed_at_any_depth() -> None:
    kit = Kit()
    sub, (hip, shin, toe), _ = limb(kit)
    one, two = kit.root.add(sub, pose=OFF), kit.root.add(sub)
    kit.root.revolute("Join", (two / hip, ON), (one / toe, OFF), 0.1)
    before = kit.document.truth.poses()
    kit.root.fix(two / shin)
    truth = kit.document.truth
    for path, pose in truth.poses().items():
        assert pose == pytest.approx(before[path], abs=1e-12)
    assert truth.body_of((two / shin).path).fixed
    moved = truth.poses({"Join": 0.9})
    assert moved[(two / hip).path] == pytest.approx(before[(two / hip).path], abs=1e-12)
    occurrences = definition(kit.document)["rootAssembly"]["occurrences"]
    assert [tuple(o["path"]) for o in occurrences if o["fixed"]] == [(two / shin).path]
