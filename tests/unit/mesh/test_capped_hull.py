"""Hulls of few vertices: close to the whole hull, in any order of the points."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.fit import capped_hull
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import along, half_spaces
from tests.support.solids import of_mesh


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
    assert hull.closed()
    assert beyond(hull, hull) == pytest.approx(0, abs=1e-12)
    assert len(convex_hull(hull.vertices).vertices) == len(hull.vertices)


def test_hull_within_the_cap_stays_and_the_order_of_vertices_does_not_matter():
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
