"""The solids that the local Onshape serves: closed, and their mass properties exact."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.frames import frame, turn

SHAPES = {
    "box": solids.box(0.1, 0.2, 0.3),
    "plate": solids.extrude(
        outlines.rounded_rectangle(0.2, 0.1, 0.02),
        0.01,
        0.001,
        [outlines.circle(0.005, (x, y), 12) for x in (-0.08, 0.08) for y in (-0.03, 0.03)],
    ),
    "bent": solids.extrude(outlines.stroke([(0, 0), (0.018, 0.028), (0.004, 0.062)], 0.0065), 0.01, 0.001),
    "gear": solids.extrude(outlines.gear(14, 0.014), 0.006, 0, [outlines.circle(0.004)]),
    "link": solids.extrude(outlines.hull(outlines.circle(0.02), outlines.circle(0.01, (0.1, 0))), 0.006),
    "cylinder": solids.cylinder(0.1, 0.2, 0.01),
    "tube": solids.tube(0.1, 0.05, 0.2, 0.01),
    "ball": solids.ball(0.1),
}


@pytest.mark.parametrize("name", SHAPES)
def test_every_edge_is_shared_by_two_triangles_in_opposite_directions(name):
    solid = SHAPES[name]
    corners = solid.triangles
    directed = [(int(a), int(b)) for t in corners for a, b in zip(t, np.roll(t, -1), strict=True)]
    assert len(directed) == len(set(directed))
    assert {(b, a) for a, b in directed} == set(directed)
    assert solid.properties.volume > 0


def test_a_box_has_the_closed_form_mass_properties():
    x, y, z = 0.12, 0.34, 0.05
    found = solids.box(x, y, z, at=(1.0, -2.0, 3.0)).properties
    assert found.volume == pytest.approx(x * y * z, rel=1e-13)
    assert found.area == pytest.approx(2 * (x * y + y * z + z * x), rel=1e-13)
    assert found.centroid == pytest.approx([1, -2, 3], abs=1e-13)
    expected = x * y * z / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    assert found.inertia == pytest.approx(expected, abs=1e-15)


def test_a_tube_approaches_the_closed_form_as_its_polygon_gets_finer():
    outer, inner, height = 0.05, 0.03, 0.08
    volume = np.pi * (outer**2 - inner**2) * height
    axial = volume * (outer**2 + inner**2) / 2
    errors = []
    for segments in (32, 128, 512):
        found = solids.tube(outer, inner, height, segments=segments).properties
        errors.append(max(abs(found.volume / volume - 1), abs(found.inertia[2, 2] / axial - 1)))
        across = volume * (3 * (outer**2 + inner**2) + height**2) / 12
        assert found.inertia[0, 0] == pytest.approx(across, rel=2 * errors[-1])
    assert errors[0] > 10 * errors[1] > 100 * errors[2]
    assert errors[2] < 1e-4


def test_a_ball_has_its_centroid_amid_and_an_isotropic_inertia():
    found = solids.ball(0.1, 96, 48).properties
    assert found.centroid == pytest.approx([0, 0, 0], abs=1e-9)
    assert found.volume == pytest.approx(4 / 3 * np.pi * 1e-3, rel=5e-3)
    assert np.diag(found.inertia) == pytest.approx([2 / 5 * found.volume * 0.01] * 3, rel=5e-3)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_moving_a_solid_moves_its_centroid_and_turns_its_inertia(seed):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    pose = turn(axis / np.linalg.norm(axis), rng.uniform(-3, 3), rng.uniform(-1, 1, 3))
    before, after = SHAPES["link"].properties, SHAPES["link"].moved(pose).properties
    R = pose[:3, :3]
    # Vertices are put back on the 0.1 µm grid.
    assert after.centroid == pytest.approx(R @ before.centroid + pose[:3, 3], abs=1e-6)
    assert after.inertia == pytest.approx(R @ before.inertia @ R.T, abs=1e-4 * np.trace(before.inertia))


def test_a_part_of_two_shells_weighs_as_much_as_both():
    one, two = SHAPES["box"], SHAPES["tube"].moved(frame((1, 0, 0)))
    both = (one + two).properties
    assert both.volume == pytest.approx(one.properties.volume + two.properties.volume, rel=1e-12)
    assert both.area == pytest.approx(one.properties.area + two.properties.area, rel=1e-12)


def test_an_inset_rectangle_is_smaller_by_the_distance_on_each_side():
    inner = outlines.inset(np.array([(0, 0), (4, 0), (4, 2), (0, 2)], float), 0.5)
    assert inner == pytest.approx(np.array([(0.5, 0.5), (3.5, 0.5), (3.5, 1.5), (0.5, 1.5)]))


def test_triangles_of_an_outline_with_holes_have_its_area():
    outline = outlines.stroke([(0, 0), (3, 0), (3, 2)], 0.6)
    holes = [outlines.circle(0.3, at) for at in ((0, 0), (1.5, 0.1), (3, 2))]
    points = np.concatenate([outline, *holes])
    areas = [outlines.area(points[t]) for t in outlines.triangulate(outline, holes)]
    assert min(areas) > 0
    expected = outlines.area(outline) - sum(outlines.area(hole) for hole in holes)
    assert sum(areas) == pytest.approx(expected, rel=1e-12)


def test_an_outline_that_crosses_itself_is_refused():
    with pytest.raises(ValueError, match="crosses itself"):
        outlines.triangulate(np.array([(0, 0), (2, 2), (2, 0), (0, 2), (1, 3)], float))
