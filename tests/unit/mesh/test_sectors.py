"""Sectors of what is round: which parts have a hole right through, and what the cuts leave."""

import manifold3d
import numpy as np
import pytest

from stages.mesh.decompose import DecomposeOptions, pieces, read, search
from stages.mesh.decompose.sectors import COUNT, hole, sectors
from stages.mesh.surface import Surface, weld
from tests.fake_onshape import solids
from tests.support.decomposing import decomposition


def surface_of(solid) -> Surface:
    surface, _ = weld(solid.vertices, solid.triangles.astype(np.int64))
    return surface


def turned(surface: Surface, axis: int) -> Surface:
    """With z along another axis."""
    return Surface(np.roll(surface.vertices, axis - 2, axis=1), surface.triangles)


def body(surface: Surface) -> manifold3d.Manifold:
    return manifold3d.Manifold(
        manifold3d.Mesh64(surface.vertices.copy(), surface.triangles.astype(np.uint64))
    )


RING = surface_of(solids.tube(0.03, 0.022, 0.01))
PROFILE = [(0.022, 0), (0.04, 0), (0.04, 0.008), (0.028, 0.008), (0.028, 0.06), (0.022, 0.06)]
FLANGED = surface_of(solids.revolve(PROFILE, 48))
CLAMP = [(0, 0), (40, 0), (40, 10), (10, 10), (10, 40), (40, 40), (40, 50), (0, 50)]
CUP = [(0, 0), (0.03, 0), (0.03, 0.04), (0.025, 0.04), (0.025, 0.005), (0, 0.005)]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_hole_of_a_ring_is_found_along_each_axis(axis: int) -> None:
    found = hole(turned(RING, axis), 0.001)
    assert found is not None
    middle, along = found
    assert along == axis
    assert np.delete(middle, axis) == pytest.approx([0, 0], abs=1e-9)


@pytest.mark.parametrize(
    ("surface", "tolerance"),
    [
        (surface_of(solids.box(0.02, 0.03, 0.04)), 0.001),
        (surface_of(solids.extrude(CLAMP * np.array(0.001), 0.02)), 0.001),
        (surface_of(solids.revolve(CUP, 24)), 0.001),
        (RING, 0.02),
    ],
    ids=["solid", "open at a side", "closed at an end", "narrow"],
)
def test_what_has_no_hole_right_through_its_middle_has_none(surface: Surface, tolerance: float) -> None:
    assert hole(surface, tolerance) is None


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_sectors_of_a_ring_are_its_equal_parts(axis: int) -> None:
    ring = turned(RING, axis)
    through = hole(ring, 0.001)
    assert through is not None
    found = sectors(ring, through)
    assert len(found) == COUNT
    assert all(one.closed() for one in found)
    volumes = [one.volume() for one in found]
    assert sum(volumes) == pytest.approx(ring.volume(), rel=1e-9)
    assert volumes == pytest.approx([ring.volume() / COUNT] * COUNT, rel=0.05)


def test_a_flanged_tube_keeps_its_bore_and_the_corner_of_its_flange() -> None:
    tolerance = 0.0018
    options = DecomposeOptions(tolerance, search=search("normal", {}, hasty=True), sectors=True)
    found = pieces(read(decomposition(FLANGED, options)), 16)
    assert len(found) <= 16
    whole = manifold3d.Manifold.batch_boolean([body(one) for one in found], manifold3d.OpType.Add)
    assert (body(FLANGED) - whole).volume() < 1e-3 * FLANGED.volume()
    bore, around, outer = (
        manifold3d.Manifold.cylinder(0.05, radius, circular_segments=64).translate([0, 0, 0.0085])
        for radius in (0.022 - tolerance, 0.028 + tolerance, 0.04)
    )
    assert (whole ^ bore).volume() < 1e-9 * FLANGED.volume()
    assert (whole ^ (outer - around)).volume() < 0.01 * FLANGED.volume()
