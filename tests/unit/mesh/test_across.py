"""Pieces of several parts of a link as fewer, in closed form."""

import numpy as np
import pytest
import trimesh

from linkwright.stages.mesh.collide.merge_across_parts import merge_across_parts
from linkwright.stages.mesh.configuration.collider_settings import LadderSettings
from linkwright.stages.mesh.surfaces.pieces import signed_distance, volume
from linkwright.stages.robot.model.robot import Primitive, frozen
from tests.support.fidelity import Hull, fidelity
from tests.support.solids import box, joined

SETTINGS = LadderSettings(tolerance=0.001)


def ells(gap=0.0):
    """Two L-shaped parts of two boxes each, together a block of 60 × 40 × 20 mm, or that far apart."""
    lower = [box(0.06, 0.02, 0.02, at=(0, -0.01, 0)), box(0.02, 0.02, 0.02, at=(-0.02, 0.01, 0))]
    upper = [box(0.02, 0.02, 0.02, at=(x + gap, 0.01, 0)) for x in (0, 0.02)]
    return [joined(*lower), joined(*upper)], [*lower, *upper]


def test_pieces_of_two_parts_that_are_one_block_become_one():
    parts, pieces = ells()
    result = merge_across_parts(parts, pieces, SETTINGS)
    assert result.meets
    (piece,) = result.pieces
    assert volume(piece) == pytest.approx(0.06 * 0.04 * 0.02, rel=1e-5)
    measures = result.measures
    assert (measures.protrusion_max, measures.bareness_max) == pytest.approx((0, 0), abs=1e-5)
    # As near as an independent measurement says.
    seen = [trimesh.Trimesh(part.vertices, part.triangles) for part in parts]
    assert fidelity(seen, [Hull(piece.vertices)], [0.001, 0.001], points=2000).miss < 0.3


def test_gap_that_is_wider_than_the_tolerance_allows_stays_open():
    pieces = merge_across_parts(*ells(gap=0.01), SETTINGS).pieces
    # The lower part has two sides of its own; the two boxes of the upper part are joined.
    assert len(pieces) == 3
    for piece in pieces:
        assert Hull(piece.vertices).planes(np.array([[-0.005, 0.01, 0.0]]))[0] > 0.004
    parts, _ = ells(gap=0.1)
    _, touching = ells()
    far = box(0.04, 0.02, 0.02, at=(0.11, 0.01, 0))
    assert not merge_across_parts(parts, [*touching[:2], far], SETTINGS).pieces


@pytest.mark.parametrize(("size", "count"), [(0.4, 1), (0.04, 2)])
def test_every_part_counts_by_its_own_tolerance(size, count):
    """A step of 2 mm between two blocks: within the tolerance of large parts, not of small parts."""
    heights = {0.0: size / 4, size: size / 4 - 0.004}
    blocks = [box(size, size, height, at=(x, 0, 0)) for x, height in heights.items()]
    # Each in two halves, so that there is something to join at all.
    halves = [
        box(size / 2, size, height, at=(x + side * size / 4, 0, 0))
        for x, height in heights.items()
        for side in (-1, 1)
    ]
    assert len(merge_across_parts(blocks, halves, LadderSettings()).pieces) == count


def test_primitives_among_the_pieces_stay_or_are_within_joined_pieces():
    ball = Primitive("sphere", (0.01,), frozen(np.eye(4)))
    far = [box(0.02, 0.02, 0.02, at=(x, 0, 0)) for x in (0.1, 0.12)]
    parts = [box(0.0115, 0.0115, 0.0115), joined(*far)]
    pieces = merge_across_parts(parts, [ball, *far], LadderSettings(tolerance=0.006)).pieces
    (kept,) = [piece for piece in pieces if isinstance(piece, Primitive)]
    assert signed_distance(kept, np.zeros((1, 3)))[0] == pytest.approx(-0.01)
    assert len(pieces) == 2
