"""Convex hulls, whole and of few vertices: they face outwards, whatever the order of the points."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.fit import capped_hull
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import along, half_spaces
from tests.support.solids import of_mesh

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
    assert hull.is_closed()
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


def cloud(seed, count):
    """The hull of points on an ellipsoid, most of which are corners of it."""
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return convex_hull(points * [0.1, 0.06, 0.03] / np.linalg.norm(points, axis=1, keepdims=True))


def beyond(first, second):
    """How far a convex surface reaches beyond the planes of another."""
    normals, heights = half_spaces(second)
    return float((along(normals, first.vertices) - heights[:, None]).max())


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.integers(5, 300), st.integers(4, 70))
def test_capped_hull_is_convex_closed_and_has_no_more_vertices(seed, count, cap):
    hull = capped_hull(cloud(seed, count), cap)
    assert len(hull.vertices) <= cap
    assert hull.is_closed()
    assert beyond(hull, hull) == pytest.approx(0, abs=1e-12)
    assert len(convex_hull(hull.vertices).vertices) == len(hull.vertices)


def test_hull_within_the_cap_stays_in_any_order_of_its_vertices():
    surface = cloud(3, 300)
    assert capped_hull(surface, len(surface.vertices)).vertices.tolist() == surface.vertices.tolist()
    order = np.random.default_rng(4).permutation(len(surface.vertices))
    shuffled = Surface(surface.vertices[order], np.argsort(order)[surface.triangles])
    first, second = capped_hull(surface, 24), capped_hull(shuffled, 24)
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.triangles.tobytes() == second.triangles.tobytes()
    flat = Surface(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]]), np.array([[0, 1, 2], [2, 1, 0]]))
    assert capped_hull(flat, 64) is None


@pytest.mark.parametrize(("cap", "share"), [(64, 0.01), (32, 0.025), (16, 0.06)])
def test_hull_neither_stands_out_nor_leaves_bare_much(cap, share):
    whole = of_mesh(trimesh.creation.icosphere(subdivisions=4, radius=0.05))
    hull = capped_hull(whole, cap)
    diagonal = 0.1 * np.sqrt(3)
    assert beyond(whole, hull) < share * diagonal
    assert np.linalg.norm(hull.vertices, axis=1).max() - 0.05 < share * diagonal
    assert hull.volume() == pytest.approx(whole.volume(), rel=0.12)


def test_flat_faces_of_a_rounded_box_keep_their_places():
    radius = 0.002
    corners = trimesh.creation.box((0.08, 0.05, 0.02)).vertices
    ball = trimesh.creation.icosphere(subdivisions=3, radius=radius).vertices
    whole = convex_hull(np.concatenate([ball + corner for corner in corners]))
    assert len(whole.vertices) > 300
    hull = capped_hull(whole, 64)
    assert np.ptp(hull.vertices, axis=0) == pytest.approx(np.ptp(whole.vertices, axis=0), abs=radius / 2)
    assert hull.volume() == pytest.approx(whole.volume(), rel=0.02)
