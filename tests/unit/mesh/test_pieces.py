"""Pieces: distances, half-spaces, volumes and closed surfaces, against trimesh and against each other."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.mesh.surfaces import pieces
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.robot.dynamics.inertia import primitive_volume
from linkwright.stages.robot.model.robot import Primitive, frozen

SIZES = {"box": (0.3, 0.2, 0.05), "sphere": (0.1,), "cylinder": (0.08, 0.3), "capsule": (0.08, 0.3)}
KINDS = sorted(SIZES)
POSES = st.tuples(*[st.floats(-3, 3)] * 3, *[st.floats(-1, 1)] * 3)


def pose(*numbers):
    matrix = trimesh.transformations.euler_matrix(*numbers[:3])
    matrix[:3, 3] = numbers[3:]
    return frozen(matrix)


def primitive(kind, numbers=(0.4, -0.9, 1.7, 0.1, 0.2, -0.3)):
    return Primitive(kind, SIZES[kind], pose(*numbers))


@pytest.mark.parametrize("kind", KINDS)
def test_surface_of_a_primitive_has_its_volume_and_distance(kind):
    shape = primitive(kind)
    surface = pieces.surface_of(shape)
    mesh = trimesh.Trimesh(surface.vertices, surface.triangles, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert surface.is_closed()
    assert mesh.volume == pytest.approx(primitive_volume(kind, shape.size), rel=1e-12)
    assert pieces.volume(shape) == primitive_volume(kind, shape.size)
    assert (pieces.vertices(shape), pieces.vertices(surface)) == (0, len(surface.vertices))
    on_it = mesh.sample(3000, seed=1) if kind != "box" else mesh.vertices
    slack = 0.002 * shape.size[0]
    assert np.abs(pieces.signed_distance(shape, on_it)).max() < (1e-15 if kind == "box" else slack)
    # By trimesh, triangle by triangle.
    points = np.random.default_rng(3).uniform(-0.5, 0.5, (60, 3))
    points = np.concatenate([points, shape.link_from_shape[:3, 3] + points * 0.1])
    expected = np.full(len(points), np.inf)
    for triangle in surface.corners:
        nearest = trimesh.triangles.closest_point(np.repeat(triangle[None], len(points), axis=0), points)
        expected = np.minimum(expected, np.linalg.norm(points - nearest, axis=1))
    distances = pieces.signed_distance(shape, points)
    assert np.abs(np.abs(distances) - expected).max() < slack
    normals, heights = pieces.half_spaces(surface)
    inside = ((points @ normals.T) <= heights).all(axis=1)
    clear = expected > slack
    assert (distances < 0)[clear].tolist() == inside[clear].tolist()
    assert 0 < inside.mean() < 1


@pytest.mark.parametrize(
    ("kind", "size", "points", "expected"),
    [
        ("box", (2, 4, 6), [[4, 6, 3], [0.5, 0, 0], [2, 3, 4]], [5, -0.5, math.sqrt(3)]),
        ("cylinder", (1, 2), [[4, 0, 5], [0, 0, 0.9], [0.7, 0, 0]], [5, -0.1, -0.3]),
    ],
)
def test_distance_from_the_corners_of_a_primitive(kind, size, points, expected):
    shape = Primitive(kind, size, frozen(np.eye(4)))
    assert pieces.signed_distance(shape, np.array(points, dtype=float)).tolist() == pytest.approx(expected)


@settings(max_examples=40)
@given(st.sampled_from(KINDS), POSES, POSES, st.booleans())
def test_placed_piece_is_where_its_points_are(kind, first, second, mirrored):
    shape = primitive(kind, first)
    transform = pose(*second).copy()
    if mirrored:
        transform[:3, :3] @= np.diag([1.0, -1.0, 1.0])
    moved = pieces.placed(shape, frozen(transform))
    points = np.random.default_rng(5).uniform(-0.5, 0.5, (50, 3))
    there = pieces.signed_distance(moved, points @ transform[:3, :3].T + transform[:3, 3])
    assert np.allclose(there, pieces.signed_distance(shape, points), rtol=0, atol=1e-12)
    assert np.linalg.det(moved.link_from_shape[:3, :3]) == pytest.approx(1)
    surface = pieces.placed(pieces.surface_of(shape), frozen(transform))
    assert surface.volume() == pytest.approx(pieces.volume(shape), rel=1e-9)


@settings(max_examples=60)
@given(st.integers(0, 10_000), st.floats(1e-4, 1.0))
def test_half_spaces_hold_all_vertices_and_touch_each(seed, thickness):
    points = np.random.default_rng(seed).uniform(-1, 1, (30, 3)) * [1, 1, thickness]
    hull = convex_hull(points)
    normals, heights = pieces.half_spaces(hull)
    assert (points @ normals.T - heights).max() <= 1e-15
    assert np.abs((hull.vertices @ normals.T - heights).max(axis=1)).max() < 1e-12
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)


def test_box_of_twelve_triangles_has_six_half_spaces():
    normals, heights = pieces.half_spaces(pieces.surface_of(Primitive("box", (2, 4, 6), frozen(np.eye(4)))))
    assert sorted(normals.tolist()) == sorted([*np.eye(3).tolist(), *(-np.eye(3) + 0.0).tolist()])
    assert sorted(heights.tolist()) == [1, 1, 2, 2, 3, 3]
