"""What the picture is made of: primitive shapes, edges and smooth surfaces, lamps, and fewer triangles."""

import numpy as np
import pytest

from pipeline.preview import solids
from pipeline.preview.creases import normals_of
from pipeline.preview.light import key_lamps, sky_lamps
from pipeline.preview.thinning import thinned

SHAPES = {
    "ball": (solids.ellipsoid(np.full(3, 2.0)), 4 / 3 * np.pi * 8, 4 * np.pi * 4),
    "ellipsoid": (solids.ellipsoid(np.array([1.0, 2.0, 3.0])), 4 / 3 * np.pi * 6, 48.882),
    "capsule": (solids.capsule(0.5, 1.0), np.pi * (0.25 * 2 + 4 / 3 * 0.125), np.pi * (2 + 4 * 0.25)),
    "cylinder": (solids.cylinder(0.5, 1.0), np.pi * 0.25 * 2, np.pi * (2 + 2 * 0.25)),
    "box": (solids.box(np.array([1.0, 2.0, 3.0])), 48.0, 88.0),
}
"""Each with its volume and area, by formulas."""


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_has_its_volume_its_area_and_normals_that_point_outwards(name):
    shape, volume, area = SHAPES[name]
    a, b, c = np.moveaxis(shape.corners, 1, 0)
    areas = np.cross(b - a, c - a) / 2
    assert (np.cross(a, b) * c).sum() / 6 == pytest.approx(volume, rel=0.02)
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(area, rel=0.02)
    assert np.linalg.norm(shape.normals, axis=2) == pytest.approx(np.ones(shape.normals.shape[:2]))
    along = (shape.normals * (areas / np.linalg.norm(areas, axis=1, keepdims=True))[:, None]).sum(axis=2)
    assert along.min() > 0.9


def test_the_normal_of_an_ellipsoid_is_the_gradient():
    shape = solids.ellipsoid(np.array([1.0, 2.0, 3.0]))
    gradient = shape.corners / np.array([1.0, 4.0, 9.0])
    gradient /= np.linalg.norm(gradient, axis=2, keepdims=True)
    assert shape.normals == pytest.approx(gradient, abs=1e-6)


def welded(corners):
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


def test_a_box_keeps_its_edges_and_a_ball_has_none():
    box = solids.box(np.array([1.0, 2.0, 3.0]))
    assert normals_of(*welded(box.corners)) == pytest.approx(box.normals, abs=1e-12)
    ball = solids.ellipsoid(np.ones(3))
    found = normals_of(*welded(np.round(ball.corners, 9)))
    assert (found * ball.normals).sum(axis=2).min() > 0.995


def test_with_too_many_faces_at_a_corner_each_is_flat(monkeypatch):
    ball = solids.ellipsoid(np.ones(3))
    monkeypatch.setattr("pipeline.preview.creases._MOST_PAIRS", 10)
    found = normals_of(*welded(ball.corners))
    assert (found[:, 0] == found[:, 1]).all()


def test_thinned_triangles_are_fewer_and_where_they_were():
    ball = solids.ellipsoid(np.ones(3)).corners
    fewer = thinned(ball, 0.4)
    assert 20 < len(fewer) < len(ball) / 3
    assert np.linalg.norm(fewer, axis=2) == pytest.approx(np.ones(fewer.shape[:2]), abs=0.1)
    assert len(thinned(np.concatenate([ball, ball]), 1e-6)) == len(thinned(ball, 1e-6))


def test_a_point_is_lit_where_nothing_is_on_its_way_to_the_lamp():
    """By a ball: a point is in its shadow where the line to the lamp passes its middle within the radius."""
    radius = 0.5
    ball = solids.ellipsoid(np.full(3, radius)).corners
    random = np.random.default_rng(4)
    points = random.uniform(-0.9, 0.9, (4000, 3)) / np.sqrt(3)
    outside = points[np.linalg.norm(points, axis=1) > radius + 0.02]
    for lamp in (*key_lamps(np.array([0.6, 0.0, 0.8]), ball), *sky_lamps(ball)):
        along = outside @ lamp.direction
        passing = np.linalg.norm(outside - along[:, None] * lamp.direction, axis=1)
        clear = np.abs(passing - radius) > 0.03
        dark = (along < 0) & (passing < radius)
        lit = lamp.reaches(outside.astype(np.float32), np.zeros((2, len(outside)), np.float32), 0.01)
        assert (lit == ~dark)[clear].all()
        assert 50 < dark.sum() < len(dark) / 2


def test_the_lamps_have_their_power_and_are_above_the_ground():
    ball = solids.ellipsoid(np.full(3, 0.5)).corners
    sky, key = sky_lamps(ball), key_lamps(np.array([0.6, 0.0, 0.8]), ball)
    assert all(lamp.direction[2] > 0.19 for lamp in sky)
    mean = sum(lamp.direction for lamp in key)
    assert mean / np.linalg.norm(mean) == pytest.approx([0.6, 0.0, 0.8], abs=0.02)
    assert [lamp.is_key for lamp in (*sky, *key)] == [False] * len(sky) + [True] * len(key)
