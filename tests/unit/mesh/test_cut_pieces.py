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
from tests.unit.mesh.test_decompose import BRACKET, CLAMP, RING, body, shuffled, union
from tests.unit.mesh.test_decompose import surface_of as drawn

PROFILE = [(0.022, 0), (0.04, 0), (0.04, 0.008), (0.028, 0.008), (0.028, 0.06), (0.022, 0.06)]
FLANGED = drawn(solids.revolve(PROFILE, 48))


def test_a_bracket_is_two_plates_and_a_clamp_three() -> None:
    for surface, count in ((BRACKET, 2), (CLAMP, 3)):
        found = cut(surface, 0.001)
        assert len(found) == count
        assert all(piece.closed() and piece.volume() > 0 for piece in found)
        assert union(found).volume() == pytest.approx(surface.volume(), rel=5e-3)
        assert (body(surface) - union(found)).volume() < 1e-5 * surface.volume()


@pytest.mark.parametrize("vertices", [64, 12])
def test_a_ring_keeps_its_hole_and_neighbours_leave_no_gap(vertices: int) -> None:
    """Shrinks the part by three tenths of a millimetre: what is left lies within the pieces."""
    found = cut(RING, 0.001, vertices)
    assert max(len(piece.vertices) for piece in found) <= vertices
    assert len(found) <= 16
    hole = manifold3d.Manifold.cylinder(0.02, 0.018, circular_segments=64).translate([0, 0, -0.005])
    assert (union(found) ^ hole).volume() == 0
    within = drawn(solids.tube(0.0297, 0.0223, 0.0094))
    core = body(Surface(within.vertices + np.array([0, 0, 0.0003]), within.triangles))
    assert (core - union(found)).volume() < 1e-5 * core.volume()


@pytest.mark.slow
def test_a_flanged_tube_keeps_its_bore_and_the_corner_of_its_flange() -> None:
    tolerance = 0.0018
    found = cut(FLANGED, tolerance)
    assert len(found) <= 16
    whole = union(found)
    assert (body(FLANGED) - whole).volume() < 1e-3 * FLANGED.volume()
    assert judge(FLANGED, tolerance).measure(found).bareness_max < 1e-5
    bore, around, outer = (
        manifold3d.Manifold.cylinder(0.05, radius, circular_segments=64).translate([0, 0, 0.0085])
        for radius in (0.022 - 2 * tolerance, 0.028 + tolerance, 0.04)
    )
    assert (whole ^ bore).volume() < 1e-9 * FLANGED.volume()
    assert (whole ^ (outer - around)).volume() < 0.02 * FLANGED.volume()


def test_a_mesh_with_a_bad_edge_is_cut_at_its_own_surface() -> None:
    """One triangle too many: the pieces are those of the part, not thicker."""
    fin = np.array([[0, 1, len(CLAMP.vertices)]])
    tip = CLAMP.vertices[:2].mean(axis=0, keepdims=True) * [1, 1, 0.9]
    found = union(
        cut(Surface(np.concatenate([CLAMP.vertices, tip]), np.concatenate([CLAMP.triangles, fin])), 0.001)
    )
    assert (body(CLAMP) - found).volume() < 0.01 * CLAMP.volume()
    assert (found - body(CLAMP)).volume() < 0.06 * CLAMP.volume()


@pytest.mark.slow
def test_no_fewer_of_the_pieces_would_do() -> None:
    """Any two of them joined are too far off."""
    part = judge(RING, 0.001)
    cutter = PieceCutter(part, 64)
    found = cutter.cut()
    assert found.near
    assert part.near(found.pieces)
    assert len(cutter.join(cutter.parts_of(found.pieces)).pieces) == len(found.pieces)


@pytest.mark.slow
def test_the_order_of_the_input_changes_no_corner() -> None:
    for surface in (BRACKET, CLAMP):
        plain = [piece.vertices.tolist() for piece in cut(surface, 0.001)]
        for seed in range(2):
            assert [piece.vertices.tolist() for piece in cut(shuffled(surface, seed), 0.001)] == plain


def test_pieces_are_not_joined_across_a_hole_however_little_volume_that_adds() -> None:
    """A plate of 300 mm with a hole of 8 mm, as four bars around it: to close it adds 0.07 %."""
    whole, hole, thick = 0.3, 0.008, 0.004
    side = (whole - hole) / 2
    bars = [
        box(*size, at=at)
        for x in (-1, 1)
        for size, at in (
            ((side, whole, thick), (x * (hole + side) / 2, 0, 0)),
            ((hole, side, thick), (0, x * (hole + side) / 2, 0)),
        )
    ]
    cutter = PieceCutter(judge(joined(*bars), 0.001), 64)
    found = [surface_of(piece) for piece in cutter.join(cutter.parts_of(bars)).pieces]
    assert 1 < len(found) <= 4
    pin = manifold3d.Manifold.cube([0.003, 0.003, 0.003], center=True)
    assert (union(found) ^ pin).volume() < 1e-15


@pytest.mark.parametrize("tolerance", [0.01, 0.0002])
def test_how_far_places_are_out_is_known_in_closed_form(tolerance: float) -> None:
    """Of two bars 60 mm apart, by a grid, and where that would be too large."""
    bars = joined(*(box(0.02, 0.1, 0.1, at=(x, 0, 0)) for x in (-0.04, 0.04)))
    field = Field.of(Target.of(bars), tolerance)
    assert (field.values is None) == (tolerance < 0.001)
    places = np.array([[0, 0, 0], [0.04, 0, 0], [0.03 - 2 * tolerance, 0, 0], [0.03, 0, 0]])
    assert field(places) == pytest.approx([min(0.03 / tolerance, 10), 0, 2, 0], rel=0.15, abs=0.25)
