"""The camera: all of the robot is in the picture, in its middle, and as large as can be."""

import numpy as np
import pytest

from linkwright.stages.show.preview.camera import _FILLED, framing, turned

WIDTH, HEIGHT = 960, 720
DIRECTIONS = [(0.7, -0.6, 0.4), (-1, 0.2, 0.1), (0, 0, 1), (0.3, 0.3, -0.9)]


def points(seed, size=1.0, at=(0.0, 0.0, 0.0)):
    random = np.random.default_rng(seed)
    return random.uniform(-1, 1, (40, 3)) * random.uniform(0.05, 1, 3) * size + at


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize(("seed", "size"), [(0, 1.0), (1, 1.0), (2, 0.005), (3, 50.0)])
def test_the_points_fill_the_picture_one_way_and_are_in_its_middle_both(direction, seed, size):
    found = points(seed, size, at=(3 * size, -size, 7 * size))
    camera = framing(found, np.array(direction), WIDTH, HEIGHT)
    places = camera.projected(found)
    assert (places[:, 2] > 0).all()
    shares = []
    for axis, across in enumerate((WIDTH, HEIGHT)):
        low, high = places[:, axis].min(), places[:, axis].max()
        assert low + high == pytest.approx(across, abs=0.01 * across + 40)
        shares.append(max(high - across / 2, across / 2 - low) / (across / 2))
    assert max(shares) == pytest.approx(_FILLED, rel=1e-9)
    # Of the way that is filled both edges are touched.
    axis = int(np.argmax(shares))
    across = (WIDTH, HEIGHT)[axis]
    assert places[:, axis].min() == pytest.approx(across * (1 - _FILLED) / 2, abs=1e-6)
    assert places[:, axis].max() == pytest.approx(across * (1 + _FILLED) / 2, abs=1e-6)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_a_ray_through_a_place_meets_the_point_that_is_seen_there(direction):
    found = points(5)
    camera = framing(found, np.array(direction), WIDTH, HEIGHT)
    right, down, near = camera.projected(found).T
    assert camera.position + camera.rays(right, down) / near[:, None] == pytest.approx(found, abs=1e-9)


def test_up_is_up_right_is_right_and_the_camera_stands_where_it_is_said():
    cube = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    camera = framing(cube, np.array([0.0, -1.0, 0.2]), WIDTH, HEIGHT)
    assert camera.position[1] < -1
    assert camera.position[2] > 0
    low, high, left, right = camera.projected(np.array([[0, 0, -1], [0, 0, 1], [-1, 0, 0], [1, 0, 0.0]]))
    assert low[1] > high[1]
    assert left[0] < right[0]
    assert np.linalg.det(camera.world_from_camera) == pytest.approx(1.0)


def test_a_turn_is_about_the_vertical():
    assert turned(np.array([1.0, 0.0, 0.5]), np.pi / 2) == pytest.approx([0, 1, 0.5])
