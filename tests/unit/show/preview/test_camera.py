"""The camera: all of the robot is in the picture, in its middle, and as large as can be."""

import numpy as np
import pytest

from linkwright.stages.show.preview.camera import _FILLED, framing, turned

SIZE = np.array([960, 720])
DIRECTIONS = [(0.7, -0.6, 0.4), (-1, 0.2, 0.1), (0, 0, 1), (0.3, 0.3, -0.9)]


def points(seed, size=1.0, at=(0.0, 0.0, 0.0)):
    random = np.random.default_rng(seed)
    return random.uniform(-1, 1, (40, 3)) * random.uniform(0.05, 1, 3) * size + at


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize(("seed", "size"), [(0, 1.0), (2, 0.005), (3, 50.0)])
def test_points_fill_the_picture_along_an_axis_and_are_in_its_middle(direction, seed, size):
    cloud = points(seed, size, at=(3 * size, -size, 7 * size))
    places = framing(cloud, np.array(direction), *SIZE).projected(cloud)
    assert (places[:, 2] > 0).all()
    low, high = places[:, :2].min(axis=0), places[:, :2].max(axis=0)
    assert (np.abs(low + high - SIZE) <= 0.01 * SIZE + 40).all()
    shares = np.maximum(high - SIZE / 2, SIZE / 2 - low) / (SIZE / 2)
    assert shares.max() == pytest.approx(_FILLED, rel=1e-9)
    # Along the axis that is filled both edges are touched.
    axis = shares.argmax()
    edges = SIZE[axis] * (1 - _FILLED) / 2, SIZE[axis] * (1 + _FILLED) / 2
    assert (low[axis], high[axis]) == pytest.approx(edges, abs=1e-6)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_ray_through_a_place_meets_the_point_that_is_seen_there(direction):
    cloud = points(5)
    camera = framing(cloud, np.array(direction), *SIZE)
    right, down, near = camera.projected(cloud).T
    assert camera.position + camera.rays(right, down) / near[:, None] == pytest.approx(cloud, abs=1e-9)


def test_up_is_up_right_is_right_and_a_turn_is_about_the_vertical():
    cube = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    camera = framing(cube, np.array([0.0, -1.0, 0.2]), *SIZE)
    assert (camera.position[1] < -1, camera.position[2] > 0) == (True, True)
    low, high, left, right = camera.projected(np.array([[0, 0, -1], [0, 0, 1], [-1, 0, 0], [1, 0, 0.0]]))
    assert (low[1] > high[1], left[0] < right[0]) == (True, True)
    assert np.linalg.det(camera.world_from_camera) == pytest.approx(1.0)
    assert turned(np.array([1.0, 0.0, 0.5]), np.pi / 2) == pytest.approx([0, 1, 0.5])
