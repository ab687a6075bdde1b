"""Pieces that planes cut: as few as are near enough, no surface bare, holes open, whatever the mesh."""

import manifold3d
import numpy as np
import pytest

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.collide.cut_pieces import PieceCutter
from linkwright.stages.mesh.measure import Target
from linkwright.stages.mesh.measure.field import Field
from linkwright.stages.mesh.surfaces.pieces import surface_of
from tests.fake_onshape import solids
from tests.support.decomposing import cut, judge
from tests.support.solids import box, joined
from tests.unit.mesh.test_decompose import (
    BRACKET,
    CLAMP,
    RING,
    assert_plates,
    assert_ring,
    body,
    shuffled,
    union,
)
from tests.unit.mesh.test_decompose import surface_of as drawn


@pytest.mark.parametrize(("surface", "count"), [(BRACKET, 2), (CLAMP, 3)], ids=["bracket", "clamp"])
def test_bracket_is_two_plates_and_a_clamp_three(surface, count):
    assert_plates(cut(surface, 0.001), surface, count, 1e-5)


@pytest.mark.parametrize("vertices", [64, 12])
def test_ring_keeps_its_hole_and_neighbours_leave_no_gap(vertices):
    assert_ring(cut(RING, 0.001, vertices), vertices, 1e-5)


@pytest.mark.slow
def test_flanged_tube_keeps_its_bore_and_the_corner_of_its_flange():
    profile = [(0.022, 0), (0.04, 0), (0.04, 0.008), (0.028, 0.008), (0.028, 0.06), (0.022, 0.06)]
    flanged, tolerance = drawn(solids.revolve(profile, 48)), 0.0018
    pieces = cut(flanged, tolerance)
    assert len(pieces) <= 16
    whole = union(pieces)
    assert (body(flanged) - whole).volume() < 1e-3 * flanged.volume()
    assert judge(flanged, tolerance).measure(pieces).bareness_max < 1e-5
    bore, around, outer = (
        manifold3d.Manifold.cylinder(0.05, radius, circular_segments=64).translate([0, 0, 0.0085])
        for radius in (0.022 - 2 * tolerance, 0.028 + tolerance, 0.04)
    )
    assert (whole ^ bore).volume() < 1e-9 * flanged.volume()
    assert (whole ^ (outer - around)).volume() < 0.02 * flanged.volume()


def test_mesh_with_a_bad_edge_is_cut_at_its_own_surface():
    """One triangle too many: the pieces are those of the part, not thicker."""
    tip = CLAMP.vertices[:2].mean(axis=0, keepdims=True) * [1, 1, 0.9]
    points = np.concatenate([CLAMP.vertices, tip])
    whole = union(cut(Surface(points, np.vstack([CLAMP.triangles, [0, 1, len(CLAMP.vertices)]])), 0.001))
    assert (body(CLAMP) - whole).volume() < 0.01 * CLAMP.volume()
    assert (whole - body(CLAMP)).volume() < 0.06 * CLAMP.volume()


@pytest.mark.slow
def test_no_fewer_of_the_pieces_would_do():
    """Any two of them joined are too far off."""
    part = judge(RING, 0.001)
    cutter = PieceCutter(part, 64)
    result = cutter.cut()
    assert result.is_near
    assert part.near(result.pieces)
    assert len(cutter.join(cutter.prepare(result.pieces)).pieces) == len(result.pieces)


@pytest.mark.slow
def test_order_of_the_input_changes_no_corner():
    for surface in (BRACKET, CLAMP):
        plain = [piece.vertices.tolist() for piece in cut(surface, 0.001)]
        for seed in range(2):
            assert [piece.vertices.tolist() for piece in cut(shuffled(surface, seed), 0.001)] == plain


def test_pieces_are_not_joined_across_a_hole_however_small():
    """A plate of 300 mm with a hole of 8 mm, as four bars around it: to close it adds 0.07 %."""
    whole, hole, thick = 0.3, 0.008, 0.004
    side, off = (whole - hole) / 2, (whole + hole) / 4
    bars = [box(side, whole, thick, at=(x * off, 0, 0)) for x in (-1, 1)]
    bars += [box(hole, side, thick, at=(0, y * off, 0)) for y in (-1, 1)]
    cutter = PieceCutter(judge(joined(*bars), 0.001), 64)
    pieces = [surface_of(piece) for piece in cutter.join(cutter.prepare(bars)).pieces]
    assert 1 < len(pieces) <= 4
    pin = manifold3d.Manifold.cube([0.003, 0.003, 0.003], center=True)
    assert (union(pieces) ^ pin).volume() < 1e-15


@pytest.mark.parametrize("tolerance", [0.01, 0.0002])
def test_field_has_the_distances_of_closed_forms(tolerance):
    """The target is two bars 60 mm apart, by a grid, and where that would be too large."""
    bars = joined(*(box(0.02, 0.1, 0.1, at=(x, 0, 0)) for x in (-0.04, 0.04)))
    field = Field.of(Target.of(bars), tolerance)
    assert (field.values is None) == (tolerance < 0.001)
    places = np.array([[0, 0, 0], [0.04, 0, 0], [0.03 - 2 * tolerance, 0, 0], [0.03, 0, 0]])
    assert field(places) == pytest.approx([min(0.03 / tolerance, 10), 0, 2, 0], rel=0.15, abs=0.25)
