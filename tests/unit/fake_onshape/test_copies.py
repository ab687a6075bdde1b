"""Patterns, mirrors and occurrences fixed one by one, in the documents' own kinematics."""

import pytest

from tests.fake_onshape.differences import differences_hold
from tests.fake_onshape.frames import inverse, product, turn
from tests.fake_onshape.mates import MIRROR
from tests.support.kit import OFF, ON

PLANE = turn((0.6, 0.0, 0.8), 0.4, (0.02, 0.3, -0.1))
REFLECTION = product(PLANE, MIRROR, inverse(PLANE))


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(
    ("kind", "values"),
    [("cylindrical", (0.04, -0.9)), ("parallel", (0.1, 0.2, 0.3, 0.4)), ("pin_slot", (0.1, 0.5))],
)
def test_at_equal_values_a_mirrored_limb_is_the_mirror_image(kit, kind, values, reverse):
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
    differences_hold(truth, truth.values(), roots=(None, (copy / toe).path))
