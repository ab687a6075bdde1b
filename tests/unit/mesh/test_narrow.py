"""Which shapes of two links are left out that touch in every pose."""

import numpy as np
import pytest

from linkwright.stages.mesh.contacts.narrow import SELDOM, narrowed

POSES = 20


def table(shape, touching):
    """(poses, m, n): `touching` has for a pair of shapes the poses in which they touch."""
    found = np.zeros((POSES, *shape), dtype=bool)
    for pair, poses in touching.items():
        found[(list(poses), *pair)] = True
    return found


ALL = range(POSES)


def pairs(mask):
    return {tuple(map(int, pair)) for pair in np.argwhere(mask)}


def test_links_that_are_apart_in_one_pose_keep_all():
    assert not narrowed(table((2, 2), {(0, 0): range(1, POSES), (1, 1): ALL[2:]}), "ab", "cd").any()


def test_without_a_pose_nothing_is_known():
    assert not narrowed(np.zeros((0, 2, 2), dtype=bool), "ab", "cd").any()


def test_of_two_colliders_that_always_touch_the_others_are_kept():
    found = narrowed(table((2, 3), {(0, 1): ALL, (1, 2): ALL[:15], (0, 0): [3]}), "ab", "cde")
    assert pairs(found) == {(0, 1)}


def test_teeth_of_gears_are_left_out_as_a_whole():
    """In each pose other teeth touch; the pads (2 and 3) touch in some."""
    teeth = {(0, 0): ALL[::3], (1, 0): ALL[1::3], (0, 2): ALL[2::3]}
    found = narrowed(table((3, 4), {**teeth, (2, 3): [0, 1]}), "ggp", "hhhq")
    assert pairs(found) == {(i, j) for i in (0, 1) for j in (0, 1, 2)}


def test_teeth_round_a_hub_are_left_out_with_it_and_a_seldom_touching_tip_is_not():
    often, seldom = int(SELDOM * POSES) + 1, int(SELDOM * POSES)
    rolling = table((2, 2), {(0, 0): ALL, (1, 1): ALL[:often]})
    assert pairs(narrowed(rolling, "gg", "hh")) == {(0, 0), (0, 1), (1, 0), (1, 1)}
    one_piece = table((2, 2), {(0, 0): ALL, (1, 1): ALL[:seldom]})
    assert pairs(narrowed(one_piece, "gg", "hh")) == {(0, 0)}


def test_where_no_two_colliders_always_touch_all_are_left_out():
    found = narrowed(table((2, 2), {(0, 0): ALL[:10], (1, 1): ALL[10:]}), "ab", "cd")
    assert found.all()


def test_where_the_rest_always_touches_too_all_are_left_out():
    always = {(0, 0): ALL, (1, 1): ALL[:10], (2, 2): ALL[10:]}
    assert narrowed(table((3, 3), always), "abc", "def").all()


@pytest.mark.parametrize("seed", range(200))
def test_no_contact_is_lost_without_need(seed):
    rng = np.random.default_rng(seed)
    m, n = rng.integers(1, 6, 2)
    one, other = rng.integers(0, 3, m).tolist(), rng.integers(0, 3, n).tolist()
    touching = rng.random((POSES, m, n)) < rng.choice([0.02, 0.5, 0.97, 1.0], (m, n))
    found = narrowed(touching, one, other)
    always = touching.any(axis=(1, 2)).all()
    assert found.any() == always
    if found.all():
        return
    left = touching & ~found
    assert not left.any(axis=(1, 2)).all()
    for i, j in pairs(found):
        block = np.ix_(
            [k for k in range(m) if one[k] == one[i]], [k for k in range(n) if other[k] == other[j]]
        )
        assert touching[:, *block].any(axis=(1, 2)).all()
        assert touching[:, i, j].all() or found[block].all()
    assert not (touching.all(axis=0) & ~found).any()
