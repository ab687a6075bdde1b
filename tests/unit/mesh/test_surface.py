"""Figures of a surface, against plain definitions."""

from collections import Counter

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from linkwright.stages.formats.meshes.surface import _SKEW, Surface, weld

COORDINATES = st.floats(-10, 10, width=32)
SURFACES = st.builds(
    Surface,
    arrays(np.float64, (5, 3), elements=COORDINATES),
    st.integers(0, 8).flatmap(lambda count: arrays(np.int64, (count, 3), elements=st.integers(0, 4))),
)
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
BOX = Surface(
    np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 2.0) for z in (0.0, 3.0)]),
    np.array([half for a, b, c, d in SIDES for half in ((a, b, c), (a, c, d))]),
)


@given(SURFACES)
def test_normals_are_cross_products_to_the_bit(surface):
    a, b, c = np.moveaxis(surface.corners, 1, 0)
    assert surface.normals().tobytes() == np.cross(b - a, c - a).tobytes()


@given(SURFACES, arrays(np.float64, 3, elements=COORDINATES))
def test_cones_are_sixths_of_determinants(surface, apex):
    expected = [np.linalg.det(corners - apex) / 6 for corners in surface.corners]
    np.testing.assert_allclose(surface.cone_volumes(apex), expected, atol=1e-11)


@given(SURFACES)
def test_closed_is_every_edge_as_often_in_either_sense(surface):
    edges = Counter((row[k], row[(k + 1) % 3]) for row in surface.triangles.tolist() for k in range(3))
    as_often = all(edges[a, b] == edges[b, a] for a, b in edges)
    assert surface.closed() == (bool(edges) and as_often)


def test_a_box_is_closed_and_without_a_face_it_is_open():
    assert BOX.closed()
    assert BOX.volume() == 6.0
    assert BOX.area() == 22.0
    assert BOX.flipped().volume() == -6.0
    lacking = Surface(BOX.vertices, BOX.triangles[1:])
    assert not lacking.closed()
    assert lacking.volume() == 0.0


@pytest.mark.parametrize("kind", ["far", "near each other", "across the skew line", "at one place"])
def test_points_within_the_tolerance_become_one_and_triangles_are_in_order(kind):
    rng = np.random.default_rng(11)
    points = rng.integers(0, 4, (60, 3)) / 20 + rng.choice([0.0, 0.9e-8, 1.1e-8], (60, 3))
    if kind == "far":
        points += [1000.0, -20.0, 3.0]
    if kind == "across the skew line":
        first, second = np.linalg.svd([_SKEW])[2][1:]
        points = rng.integers(0, 5, (60, 1)) / 50 * first + rng.integers(0, 9, (60, 1)) * 0.9e-8 * second
    if kind == "at one place":
        points = np.full((60, 3), 0.1) + rng.integers(0, 2, (60, 1)) * [[1e-9, 0, 0]]
    triangles = np.concatenate([rng.integers(0, 60, (80, 3)), [[0, 1, 2], [0, 1, 2], [2, 1, 0]]])
    surface, kept = weld(points, triangles)
    # Slowly: each point's group, whose first point in order is that of all.
    used = np.unique(triangles)
    size = np.linalg.norm(np.ptp(points[used], axis=0))
    reach = min(max(1e-8, 1e-9 * size), 1e-3 * size)
    graph = nx.Graph()
    graph.add_nodes_from(used.tolist())
    apart = np.linalg.norm(points[used][:, None] - points[used][None], axis=2)
    graph.add_edges_from((used[i], used[j]) for i, j in zip(*np.nonzero(apart <= reach), strict=True))
    place = {}
    for group in nx.connected_components(graph):
        place |= dict.fromkeys(group, min(tuple(points[index]) for index in group))
    corners = [tuple(place[index] for index in row) for row in triangles.tolist()]
    turned = [(*row[row.index(min(row)) :], *row[: row.index(min(row))]) for row in corners]
    left = [number for number, row in enumerate(corners) if len({*row}) == 3]
    expected = sorted(left, key=turned.__getitem__)
    assert kept.tolist() == expected
    assert [tuple(map(tuple, row)) for row in surface.corners.tolist()] == [turned[k] for k in expected]
