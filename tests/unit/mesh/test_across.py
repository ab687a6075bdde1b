"""Pieces of several parts of a link as fewer, in closed form."""

import numpy as np
import pytest

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.collide.merge_across_parts import across
from linkwright.stages.mesh.configuration.collider_settings import LadderSettings
from linkwright.stages.mesh.surfaces.pieces import signed_distance, volume
from linkwright.stages.robot.model.robot import Primitive, frozen
from tests.support.fidelity import Hull, fidelity
from tests.support.solids import box, joined

SETTINGS = LadderSettings(tolerance=0.001)


def ells(gap: float = 0.0) -> tuple[list[Surface], list[Surface]]:
    """Two L-shaped parts of two boxes each, together a block of 60 × 40 × 20 mm, or that far apart."""
    lower = [box(0.06, 0.02, 0.02, at=(0, -0.01, 0)), box(0.02, 0.02, 0.02, at=(-0.02, 0.01, 0))]
    upper = [
        box(0.02, 0.02, 0.02, at=(0 + gap, 0.01, 0)),
        box(0.02, 0.02, 0.02, at=(0.02 + gap, 0.01, 0)),
    ]
    return [joined(*lower), joined(*upper)], [*lower, *upper]


def test_pieces_of_two_parts_that_are_one_block_become_one() -> None:
    parts, pieces = ells()
    made = across(parts, pieces, SETTINGS)
    assert made.meets
    assert len(made.pieces) == 1
    assert volume(made.pieces[0]) == pytest.approx(0.06 * 0.04 * 0.02, rel=1e-5)
    assert made.measures is not None
    assert made.measures.protrusion_max == pytest.approx(0, abs=1e-5)
    assert made.measures.bareness_max == pytest.approx(0, abs=1e-5)


def test_a_gap_that_is_wider_than_the_tolerance_allows_stays_open() -> None:
    parts, pieces = ells(gap=0.01)
    made = across(parts, pieces, SETTINGS)
    # The lower part has two sides of its own; the two boxes of the upper one are one.
    assert len(made.pieces) == 3
    hulls = [Hull(piece.vertices) for piece in made.pieces if isinstance(piece, Surface)]
    assert all(one.planes(np.array([[-0.005, 0.01, 0.0]]))[0] > 0.004 for one in hulls)


def test_every_part_counts_by_its_own_tolerance() -> None:
    """A step of 2 mm between two blocks: within the tolerance of large parts, not of small ones."""
    for size, count in ((0.4, 1), (0.04, 2)):
        blocks = [box(size, size, size / 4), box(size, size, size / 4 - 0.004, at=(size, 0, 0))]
        # Each in two halves, so that there is something to join at all.
        halves = [
            box(size / 2, size, height, at=(middle + side * size / 4, 0, 0))
            for middle, height in ((0, size / 4), (size, size / 4 - 0.004))
            for side in (-1, 1)
        ]
        made = across(blocks, halves, LadderSettings())
        assert len(made.pieces) == count


def test_what_cannot_be_joined_is_left_as_it_is() -> None:
    parts, _ = ells(gap=0.1)
    alone = [box(0.06, 0.02, 0.02, at=(0, -0.01, 0)), box(0.02, 0.02, 0.02, at=(-0.02, 0.01, 0))]
    far = box(0.04, 0.02, 0.02, at=(0.11, 0.01, 0))
    assert not across(parts, [*alone, far], SETTINGS).pieces


def test_primitives_among_the_pieces_stay_or_are_held_by_what_they_become() -> None:
    ball = Primitive("sphere", (0.01,), frozen(np.eye(4)))
    far = [box(0.02, 0.02, 0.02, at=(0.1, 0, 0)), box(0.02, 0.02, 0.02, at=(0.12, 0, 0))]
    round_part = joined(box(0.0115, 0.0115, 0.0115))
    made = across([round_part, joined(*far)], [ball, *far], LadderSettings(tolerance=0.006))
    assert sum(isinstance(piece, Primitive) for piece in made.pieces) == 1
    kept = next(piece for piece in made.pieces if isinstance(piece, Primitive))
    assert signed_distance(kept, np.zeros((1, 3)))[0] == pytest.approx(-0.01)
    assert len(made.pieces) == 2


def test_the_result_is_as_near_as_an_independent_measurement_says() -> None:
    import trimesh

    parts, pieces = ells()
    made = across(parts, pieces, SETTINGS)
    seen = [trimesh.Trimesh(part.vertices, part.triangles) for part in parts]
    hulls = [Hull(piece.vertices) for piece in made.pieces if isinstance(piece, Surface)]
    assert fidelity(seen, hulls, [0.001, 0.001], points=2000).miss < 0.3
