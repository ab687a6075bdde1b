"""Convex hulls: they hold all points, face outwards, and do not depend on the order of the input."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from linkwright.stages.mesh.surfaces.convex_hull import convex_hull

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
CLOUDS = arrays(np.float64, st.tuples(st.integers(1, 40), st.just(3)), elements=st.floats(-1, 1, width=32))
SQUARE = np.random.default_rng(2).uniform(0, 1, (50, 3))


def test_hull_of_a_cube_and_points_inside_is_the_cube():
    hull = convex_hull(np.concatenate([np.random.default_rng(1).uniform(0.1, 0.9, (100, 3)), CUBE]))
    assert hull.vertices.tolist() == CUBE.tolist()
    assert len(hull.triangles) == 12
    assert (hull.volume(), hull.area()) == pytest.approx((1, 6), abs=1e-15)


@settings(max_examples=100, deadline=None)
@given(CLOUDS, st.randoms(use_true_random=False))
def test_hull_is_closed_convex_and_holds_all_points_in_any_order(points, random):
    hull = convex_hull(points)
    again = convex_hull(points[random.sample(range(len(points)), len(points))])
    if hull is None:
        assert again is None
        return
    assert again.vertices.tobytes() == hull.vertices.tobytes()
    assert again.triangles.tolist() == hull.triangles.tolist()
    assert hull.closed()
    assert hull.volume() > 0
    assert {*map(tuple, hull.vertices.tolist())} <= {*map(tuple, (points + 0.0).tolist())}
    lengths = np.linalg.norm(hull.normals(), axis=1, keepdims=True)
    large = lengths[:, 0] > 1e-6
    normals = hull.normals()[large] / lengths[large]
    heights = np.einsum("fj,fpj->fp", normals, points[None] - hull.corners[large][:, :1])
    assert heights.max() < 1e-6


@pytest.mark.parametrize(
    "points",
    [
        CUBE[:3],
        CUBE[:4],
        np.zeros((10, 3)),
        SQUARE * [1, 1, 0],
        SQUARE * [1, 1, 1e-8],
        np.outer(np.arange(10), [1.0, 2.0, 3.0]),
    ],
)
def test_flat_points_have_no_hull(points):
    assert convex_hull(points) is None


def test_thin_sheet_and_a_tiny_part_have_a_hull():
    for scale, volume in (([1, 1, 1e-4], 1e-4), (1e-4, 1e-12)):
        assert convex_hull(CUBE * scale).volume() == pytest.approx(volume)
