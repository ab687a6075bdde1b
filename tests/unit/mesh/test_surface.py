"""Surfaces: their figures, and the points inside of them by the winding number of solid angles."""

from collections import Counter

import networkx as nx
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from linkwright.stages.formats.meshes.surface import _SKEW_DIRECTION, Surface, weld
from linkwright.stages.mesh.surfaces.inside import InsideTest
from linkwright.stages.mesh.surfaces.rays import LineGrid
from tests.support.fidelity import solid_angles
from tests.support.solids import joined, of_mesh


def winding(surface, points):
    """The winding number of points (n, 3): the sum of signed solid angles (Van Oosterom and Strackee)."""
    return solid_angles(points, surface.corners) / (4 * np.pi)


def points_in(surface, count, seed=1):
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    return np.random.default_rng(seed).uniform(low - 0.1, high + 0.1, (count, 3))


SHAPES = {
    "box": trimesh.creation.box((1, 2, 3)),
    "ring": trimesh.creation.annulus(0.5, 1.0, 0.3),
    "torus": trimesh.creation.torus(1.0, 0.3),
    "many slivers": trimesh.creation.cylinder(1.0, 2.0, sections=300),
    "ball": trimesh.creation.icosphere(3),
}
BALL = of_mesh(SHAPES["ball"])
HOLED = Surface(BALL.vertices, BALL.triangles[BALL.corners[:, :, 2].min(axis=1) < 0.9])


def assert_clear(surface, points, spare):
    """The points that are not near the border of the inside are judged as by the winding number."""
    number = winding(surface, points)
    clear = np.abs(number - 0.5) > 0.5 - spare
    assert InsideTest.of(surface)(points)[clear].tolist() == (number > 0.5)[clear].tolist()
    assert clear.sum() > 100


@pytest.mark.parametrize("name", sorted(SHAPES))
def test_inside_of_a_closed_surface_is_by_its_winding_number(name):
    surface = of_mesh(SHAPES[name])
    points = points_in(surface, 400)
    expected = winding(surface, points) > 0.5
    assert InsideTest.of(surface)(points).tolist() == expected.tolist()
    assert 0 < expected.mean() < 1


def test_points_over_edges_and_vertices_are_counted_once():
    """Lines through vertices and edges: a lattice of squares, seen from straight below the vertices."""
    box = of_mesh(SHAPES["box"].subdivide().subdivide())
    up = LineGrid.of(box).axes[2]
    middles = (box.corners + np.roll(box.corners, 1, axis=1)).reshape(-1, 3) / 2
    points = np.concatenate([box.vertices - up * 0.37, middles + up * 0.21])
    number = winding(box, points)
    clear = np.minimum(np.abs(number - 1), np.abs(number)) < 1e-3
    assert InsideTest.of(box)(points)[clear].tolist() == (number > 0.5)[clear].tolist()
    assert clear.sum() > 100


def test_overlapping_shells_are_inside_and_a_cavity_is_not():
    big, small = of_mesh(trimesh.creation.box((2, 2, 2))), of_mesh(trimesh.creation.icosphere(2))
    points = np.array([[0, 0, 0], [0.95] * 3, [1.05] * 3])
    assert InsideTest.of(joined(big, small))(points).tolist() == [True, True, False]
    assert InsideTest.of(joined(big, small.flipped()))(points).tolist() == [False, True, False]


@settings(max_examples=40)
@given(st.integers(0, 100_000))
def test_any_closed_soup_is_counted_as_its_winding_number(seed):
    random = np.random.default_rng(seed)
    parts = []
    for _ in range(4):
        corners = random.normal(size=(4, 3))
        tetrahedron = Surface(corners, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
        parts.append(tetrahedron if tetrahedron.volume() > 0 else tetrahedron.flipped())
    surface = joined(*parts)
    points = random.normal(size=(100, 3))
    assert InsideTest.of(surface)(points).tolist() == (winding(surface, points) > 0.5).tolist()


def test_inside_of_an_open_surface_is_that_of_most_directions():
    assert not HOLED.is_closed()
    assert_clear(HOLED, points_in(HOLED, 600), 0.2)


def test_closed_shells_and_open_shells_add_up():
    pinched = np.vstack([BALL.triangles, [[0, 0, 1]]])  # a side from a corner to itself is no hole
    closed = Surface(BALL.vertices * 0.5 + [0.7, 0, 0], pinched)
    surface = joined(closed, HOLED, Surface(BALL.vertices * 0.3, BALL.triangles).flipped())
    points = points_in(surface, 800)
    assert_clear(surface, points, 0.2)
    inside = InsideTest.of(surface)
    assert len(inside.open_part.surface.triangles) == len(HOLED.triangles)
    assert 0.1 < inside(points).mean() < 0.9


def test_plate_and_nothing_have_no_inside():
    plate, _ = weld(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    nothing = Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    for surface in (plate, nothing):
        assert not InsideTest.of(surface)(np.random.default_rng(2).uniform(0, 1, (50, 3))).any()


def test_closed_winding_is_the_winding_number():
    shifted = SHAPES["box"].copy().apply_translation((0.4, 0, 0))
    surface = joined(of_mesh(SHAPES["box"]), of_mesh(shifted), BALL.flipped())
    points = points_in(surface, 400)
    expected = np.rint(winding(surface, points)).astype(int).tolist()
    assert InsideTest.of(surface).closed_winding(points).tolist() == expected
    assert set(expected) == {-1, 0, 1, 2}


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
    assert surface.is_closed() == (bool(edges) and as_often)


def test_box_is_closed_and_without_a_face_it_is_open():
    assert BOX.is_closed()
    assert BOX.volume() == 6.0
    assert BOX.area() == 22.0
    assert BOX.flipped().volume() == -6.0
    lacking = Surface(BOX.vertices, BOX.triangles[1:])
    assert not lacking.is_closed()
    assert lacking.volume() == 0.0


@pytest.mark.parametrize("kind", ["far", "near each other", "across the skew line", "at one place"])
def test_near_points_become_one_and_triangles_are_in_order(kind):
    rng = np.random.default_rng(11)
    points = rng.integers(0, 4, (60, 3)) / 20 + rng.choice([0.0, 0.9e-8, 1.1e-8], (60, 3))
    if kind == "far":
        points += [1000.0, -20.0, 3.0]
    if kind == "across the skew line":
        first, second = np.linalg.svd([_SKEW_DIRECTION])[2][1:]
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
