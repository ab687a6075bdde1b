"""Which shapes of two links are left out that touch in every pose."""

import numpy as np
import pytest

from linkwright.stages.mesh.contacts.narrow import MAX_OTHER_CONTACT_SHARE, excluded_shape_pairs

POSES = 20
ALL = range(POSES)
OFTEN, RARE = int(MAX_OTHER_CONTACT_SHARE * POSES) + 1, int(MAX_OTHER_CONTACT_SHARE * POSES)


def pairs(mask):
    return {tuple(map(int, pair)) for pair in np.argwhere(mask)}


def every(m, n):
    return {(i, j) for i in range(m) for j in range(n)}


TEETH = {(0, 0): ALL[::3], (1, 0): ALL[1::3], (0, 2): ALL[2::3], (2, 3): [0, 1]}


@pytest.mark.parametrize(
    ("first", "second", "touching", "left_out"),
    [
        # `touching`: the poses in which a pair of shapes touches.
        ("ab", "cd", {(0, 0): ALL[1:], (1, 1): ALL[2:]}, set()),
        ("ab", "cde", {(0, 1): ALL, (1, 2): ALL[:15], (0, 0): [3]}, {(0, 1)}),
        # In each pose other teeth touch; the pads (2 and 3) touch in some.
        ("ggp", "hhhq", TEETH, {(i, j) for i in (0, 1) for j in (0, 1, 2)}),
        ("gg", "hh", {(0, 0): ALL, (1, 1): ALL[:OFTEN]}, every(2, 2)),
        ("gg", "hh", {(0, 0): ALL, (1, 1): ALL[:RARE]}, {(0, 0)}),
        ("ab", "cd", {(0, 0): ALL[:10], (1, 1): ALL[10:]}, every(2, 2)),
        ("abc", "def", {(0, 0): ALL, (1, 1): ALL[:10], (2, 2): ALL[10:]}, every(3, 3)),
    ],
    ids=["apart in one pose", "others kept", "teeth", "teeth round a hub", "tip that seldom touches",
         "no two colliders always", "rest always too"],
)  # fmt: skip
def test_shapes_that_always_touch_are_left_out(first, second, touching, left_out):
    table = np.zeros((POSES, len(first), len(second)), dtype=bool)
    for pair, poses in touching.items():
        table[(list(poses), *pair)] = True
    assert pairs(excluded_shape_pairs(table, first, second)) == left_out


def test_without_a_pose_nothing_is_left_out():
    assert not excluded_shape_pairs(np.zeros((0, 2, 2), dtype=bool), "ab", "cd").any()


@pytest.mark.parametrize("seed", range(100))
def test_no_contact_is_lost_without_need(seed):
    rng = np.random.default_rng(seed)
    m, n = rng.integers(1, 6, 2)
    first, second = rng.integers(0, 3, m), rng.integers(0, 3, n)
    touching = rng.random((POSES, m, n)) < rng.choice([0.02, 0.5, 0.97, 1.0], (m, n))
    left_out = excluded_shape_pairs(touching, first.tolist(), second.tolist())
    assert left_out.any() == touching.any(axis=(1, 2)).all()
    if left_out.all():
        return
    assert not (touching & ~left_out).any(axis=(1, 2)).all()
    for i, j in pairs(left_out):
        block = np.ix_(np.flatnonzero(first == first[i]), np.flatnonzero(second == second[j]))
        assert touching[:, *block].any(axis=(1, 2)).all()
        assert touching[:, i, j].all() or left_out[block].all()
    assert not (touching.all(axis=0) & ~left_out).any()
