"""Mates, relations, mirrors and loops in the documents' own kinematics, by closed forms."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.fake_onshape.definition import definition
from tests.fake_onshape.frames import inverse, product, turn
from tests.fake_onshape.mates import MIRROR
from tests.support.kit import OFF, ON

QUAT = (0.5, 0.5, -0.5, 0.5)
VALUES = {
    "revolute": 0.4,
    "slider": 0.03,
    "cylindrical": (0.03, 0.4),
    "pin_slot": (0.05, -0.6),
    "planar": (0.02, -0.04, 0.9),
    "parallel": (0.02, -0.04, 0.06, 0.9),
    "ball": QUAT,
}
SLIDES = {"slider": "z", "cylindrical": "z", "pin_slot": "x", "planar": "xy", "parallel": "xyz"}


def related(kind, value):
    """The first frame in the second, written out."""
    made = np.eye(4)
    numbers = list(np.atleast_1d(value))
    if kind == "ball":
        made[:3, :3] = Rotation.from_quat(np.roll(value, -1)).as_matrix()
        return made
    for axis in SLIDES.get(kind, ""):
        made["xyz".index(axis), 3] = numbers.pop(0)
    if numbers:
        (q,) = numbers
        made[:2, :2] = [[math.cos(q), -math.sin(q)], [math.sin(q), math.cos(q)]]
    return made


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kind", VALUES)
def test_a_mate_means_second_then_slides_then_turn_then_first(kit, kind, backwards):
    base, arm, hand = kit.place("Base", fixed=True), kit.place("Arm"), kit.place("Hand")
    ends = [(arm, ON), (base, OFF)]
    getattr(kit.root, kind)("Mate", *(ends[::-1] if backwards else ends), VALUES[kind])
    kit.root.revolute("Hinge", (hand, ON), (arm, OFF), 0.3)
    truth = kit.document.truth
    poses = truth.poses()
    first, second = poses[arm.path] @ ON, poses[base.path] @ OFF
    if backwards:
        first, second = second, first
    assert inverse(second) @ first == pytest.approx(related(kind, VALUES[kind]), abs=1e-12)
    assert truth.joint("Mate").value_at(poses) == pytest.approx(VALUES[kind], abs=1e-12)


def test_relations_follow_one_rule(kit):
    base, *bars = (kit.place(f"Bar {n}") for n in range(6))
    turns = [kit.root.revolute(f"T{n}", (bars[n], ON), (base, ON)) for n in range(2)]
    slides = [kit.root.slider(f"S{n}", (bars[2 + n], ON), (base, ON)) for n in range(2)]
    bolt = kit.root.cylindrical("Bolt", (bars[4], ON), (base, ON), (-0.0025, math.pi))
    kit.root.gear("Gear", *turns, 2.0)
    kit.root.linear("Linear", *slides, 0.5, reverse=True)
    kit.root.rack("Rack", turns[0], slides[0], 0.1)
    kit.root.rack("Pinion", slides[1], turns[1], 0.1, reverse=True)
    kit.root.screw("Screw", bolt, 0.005)
    truth = kit.document.truth
    by_name = {r.name: (r.driver, r.follower, pytest.approx(r.multiplier)) for r in truth.relations}
    assert by_name == {
        "Gear": ("T0", "T1", -2.0),
        "Linear": ("S0", "S1", 0.5),
        "Rack": ("T0", "S0", -0.1 / math.tau),
        "Pinion": ("S1", "T1", math.tau / 0.1),
        "Screw": ("Bolt_turn", "Bolt_slide", -0.005 / math.tau),
    }
    truth.check()
    features = definition(kit.document)["rootAssembly"]["features"]
    written = {feature["featureData"]["name"]: feature["featureData"] for feature in features}
    rule = {"relationType": "SCREW", "relationLength": 0.005, "reverseDirection": False}
    mates = [{"featureId": bolt.id, "occurrence": []}]
    assert written["Screw"] == {"name": "Screw", **rule, "mates": mates}
    assert written["Linear"]["relationRatio"] == 0.5
    kit.root.gear("Bad", turns[0], slides[0])
    with pytest.raises(ValueError, match="0 freedoms of the kind turn"):
        _ = kit.document.truth


PLANE = turn((0.6, 0.0, 0.8), 0.4, (0.02, 0.3, -0.1))
REFLECTION = product(PLANE, MIRROR, inverse(PLANE))


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(
    ("kind", "values"),
    [("cylindrical", (0.04, -0.9)), ("parallel", (0.1, 0.2, 0.3, 0.4)), ("pin_slot", (0.1, 0.5))],
)
def test_a_mirrored_limb_is_the_mirror_image_at_equal_values(kit, kind, values, reverse):
    sub = kit.document.assembly("Limb")
    hip, shin, toe = parts = [kit.place(name, sub) for name in ("hip", "shin", "toe")]
    inner = getattr(sub, kind)("Inner", (shin, ON), (hip, OFF), tuple(0.5 * value for value in values))
    toes = sub.revolute("Toes", (shin, OFF), (toe, ON), 0.2)
    base, leg = kit.place("Base", fixed=True), kit.root.add(sub)
    ends = [(leg / hip, ON), (base, OFF)]
    drive = kit.root.slider("Drive", *(ends[::-1] if reverse else ends), 0.05, (-0.1, 0.2))
    (copy,) = kit.root.mirror("Mirror 1", [leg], PLANE)
    truth = kit.document.truth
    truth.check()
    moved = {truth.joint(((), drive.id, *more)).name: -0.07 for more in ((), (copy.last.id,))}
    moved |= {(limb.path, mate.id): q for limb in (leg, copy) for mate, q in ((inner, values), (toes, 1.1))}
    for q in ({}, moved):
        poses = truth.poses(q)
        for part in parts:
            image = REFLECTION @ poses[(leg / part).path]
            assert poses[(copy / part).path] == pytest.approx(image, abs=1e-12)


def test_a_loop_must_be_declared(kit):
    base, arm = kit.elbow()
    kit.root.revolute("Again", (arm, ON), (base, ON))
    with pytest.raises(ValueError, match="'Again' closes a loop"):
        _ = kit.document.truth
