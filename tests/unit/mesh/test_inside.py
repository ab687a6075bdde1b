"""What is inside of a surface: against the winding number by solid angles."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.formats.meshes.surface import Surface, weld
from linkwright.stages.mesh.surfaces.inside import Inside
from linkwright.stages.mesh.surfaces.rays import LineGrid
from tests.support.solids import joined, of_mesh


def winding(surface, points):
    """The winding number of points (n, 3): the sum of signed solid angles (Van Oosterom and Strackee)."""
    a, b, c = (surface.corners[None, :, k] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
    top = (a * np.cross(b, c)).sum(axis=2)
    bottom = la * lb * lc + (a * b).sum(2) * lc + (b * c).sum(2) * la + (c * a).sum(2) * lb
    return (2 * np.arctan2(top, bottom)).sum(axis=1) / (4 * np.pi)


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


@pytest.mark.parametrize("name", sorted(SHAPES))
def test_a_closed_surface_has_inside_what_its_winding_number_says(name):
    surface = of_mesh(SHAPES[name])
    points = points_in(surface, 400)
    wanted = winding(surface, points) > 0.5
    assert Inside.of(surface)(points).tolist() == wanted.tolist()
    assert wanted.any()
    assert not wanted.all()


def test_points_over_edges_and_vertices_are_counted_once():
    """Lines through vertices and edges: a lattice of squares, looked at from straight below the vertices."""
    box = of_mesh(SHAPES["box"].subdivide().subdivide())
    lines = LineGrid.of(box)
    below = box.vertices - lines.axes[2] * 0.37
    middles = (box.corners + np.roll(box.corners, 1, axis=1)).reshape(-1, 3) / 2 + lines.axes[2] * 0.21
    points = np.concatenate([below, middles])
    number = winding(box, points)
    clear = np.minimum(np.abs(number - 1), np.abs(number)) < 1e-3
    assert Inside.of(box)(points)[clear].tolist() == (number > 0.5)[clear].tolist()
    assert clear.sum() > 100


def test_shells_that_overlap_are_inside_and_a_cavity_is_not():
    big, small = of_mesh(trimesh.creation.box((2, 2, 2))), of_mesh(trimesh.creation.icosphere(2))
    within, outside = np.zeros((1, 3)), np.array([[0.95, 0.95, 0.95]])
    assert Inside.of(joined(big, small))(within).tolist() == [True]
    hollow = Inside.of(joined(big, small.flipped()))
    assert hollow(within).tolist() == [False]
    assert hollow(outside).tolist() == [True]
    assert hollow(outside * 1.1).tolist() == [False]


@settings(max_examples=60)
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
    assert Inside.of(surface)(points).tolist() == (winding(surface, points) > 0.5).tolist()


def test_an_open_surface_has_inside_what_most_directions_say():
    ball = of_mesh(trimesh.creation.icosphere(3))
    holed = Surface(ball.vertices, ball.triangles[ball.corners[:, :, 2].min(axis=1) < 0.9])
    points = points_in(holed, 600)
    number = winding(holed, points)
    clear = np.abs(number - 0.5) > 0.3
    assert Inside.of(holed)(points)[clear].tolist() == (number > 0.5)[clear].tolist()
    assert not holed.closed()


def test_closed_shells_and_open_ones_add_up():
    ball = of_mesh(trimesh.creation.icosphere(3))
    holed = Surface(ball.vertices, ball.triangles[ball.corners[:, :, 2].min(axis=1) < 0.9])
    pinched = np.vstack([ball.triangles, [[0, 0, 1]]])  # a side from a corner to itself is no hole
    closed = Surface(ball.vertices * 0.5 + [0.7, 0, 0], pinched)
    inner = Surface(ball.vertices * 0.3, ball.triangles).flipped()
    surface = joined(closed, holed, inner)
    points = points_in(surface, 800)
    number = winding(surface, points)
    clear = np.abs(number - 0.5) > 0.3
    inside = Inside.of(surface)
    assert inside(points)[clear].tolist() == (number > 0.5)[clear].tolist()
    assert len(inside.holed.surface.triangles) == len(holed.triangles)
    assert 0.1 < inside(points).mean() < 0.9


def test_a_plate_and_nothing_have_no_inside():
    plate, _ = weld(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    assert not Inside.of(plate)(np.random.default_rng(2).uniform(0, 1, (50, 3))).any()
    nothing = Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    assert not Inside.of(nothing)(np.zeros((3, 3))).any()


def test_a_surface_goes_round_points_as_often_as_its_shells_lie_across_each_other():
    box = SHAPES["box"]
    shifted = box.copy()
    shifted.apply_translation((0.4, 0, 0))
    surface = joined(of_mesh(box), of_mesh(shifted), of_mesh(SHAPES["ball"]).flipped())
    points = points_in(surface, 400)
    wanted = np.rint(winding(surface, points)).astype(int)
    assert Inside.of(surface).times_around(points).tolist() == wanted.tolist()
    assert set(wanted.tolist()) == {-1, 0, 1, 2}
