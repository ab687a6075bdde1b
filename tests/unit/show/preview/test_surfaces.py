"""What the picture is made of: shapes, edges, smooth surfaces, lamps, and a camera that frames them."""

import numpy as np
import pytest

from linkwright.stages.show.preview import solids, surface
from linkwright.stages.show.preview.camera import _MAX_FILLED_SHARE, framing, turned_about_z
from linkwright.stages.show.preview.drawing import light
from linkwright.stages.show.preview.drawing.creases import normals_of
from linkwright.stages.show.preview.drawing.light import key_lamps, shadow_casters, sky_lamps
from linkwright.stages.show.preview.look import Blob, Geom, Look
from linkwright.stages.show.preview.thinning import merge_details

SHAPES = {
    "ball": (solids.ellipsoid(np.full(3, 2.0)), 4 / 3 * np.pi * 8, 4 * np.pi * 4),
    "ellipsoid": (solids.ellipsoid(np.array([1.0, 2.0, 3.0])), 4 / 3 * np.pi * 6, 48.882),
    "capsule": (solids.capsule(0.5, 1.0), np.pi * (0.25 * 2 + 4 / 3 * 0.125), np.pi * (2 + 4 * 0.25)),
    "cylinder": (solids.cylinder(0.5, 1.0), np.pi * 0.25 * 2, np.pi * (2 + 2 * 0.25)),
    "box": (solids.box(np.array([1.0, 2.0, 3.0])), 48.0, 88.0),
}
"""Each with its volume and area, by formulas."""


@pytest.mark.parametrize("name", SHAPES)
def test_shape_has_its_volume_its_area_and_outward_normals(name):
    shape, volume, area = SHAPES[name]
    a, b, c = np.moveaxis(shape, 1, 0)
    areas = np.cross(b - a, c - a) / 2
    assert (np.cross(a, b) * c).sum() / 6 == pytest.approx(volume, rel=0.02)
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(area, rel=0.02)
    outwards = (areas * shape.mean(axis=1)).sum(axis=1)
    assert outwards.min() > 0


BALL = solids.ellipsoid(np.ones(3))


def normals(corners, which=None, geom=None):
    rows = np.arange(len(corners))
    single = np.round(corners, 9).astype(np.float32)
    return normals_of(single, np.zeros_like(rows) if geom is None else geom, rows if which is None else which)


def test_box_keeps_its_edges_and_round_shapes_are_smooth():
    box = solids.box(np.array([1.0, 2.0, 3.0]))
    assert np.abs(normals(box)).max(axis=2) == pytest.approx(np.ones((12, 3)))
    assert (normals(box) * box).sum(axis=2).min() > 0
    assert (normals(BALL) * BALL).sum(axis=2).min() > 0.995
    shape = solids.ellipsoid(np.array([1.0, 1.5, 2.0]))
    gradient = shape / np.array([1.0, 2.25, 4.0])
    gradient /= np.linalg.norm(gradient, axis=2, keepdims=True)
    assert (normals(shape) * gradient).sum(axis=2).min() > 0.99


def test_normals_of_some_triangles_are_those_among_all():
    some = np.arange(5, len(BALL), 7)
    assert np.array_equal(normals(BALL, some), normals(BALL)[some])
    geom = (BALL.mean(axis=1)[:, 2] > 0).astype(np.int64)
    upper = np.flatnonzero(geom)
    assert normals(BALL, upper, geom) == pytest.approx(normals(BALL[upper]), abs=1e-6)


def test_with_too_many_faces_at_a_corner_each_is_flat(monkeypatch):
    monkeypatch.setattr("linkwright.stages.show.preview.drawing.creases._MAX_PAIRS", 10)
    flat = normals(BALL)
    assert (flat[:, 0] == flat[:, 1]).all()


def test_thinned_triangles_are_fewer_and_where_they_were():
    fewer = merge_details(BALL, 0.4)
    assert 20 < len(fewer) < len(BALL) / 3
    assert np.linalg.norm(fewer, axis=2) == pytest.approx(np.ones(fewer.shape[:2]), abs=0.1)
    assert len(merge_details(np.concatenate([BALL, BALL]), 1e-6)) == len(merge_details(BALL, 1e-6))


def test_mesh_without_triangles_is_left_out_of_many_triangles(monkeypatch):
    monkeypatch.setattr(surface, "_MAX_TRIANGLES", 10)
    place = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 1.0)
    geoms = Geom("mesh", (), *place, blob=0), Geom("box", (1.0, 1.0, 1.0), *place)
    drawn = surface.surface_of(Look(geoms, (1.0, 0.0, 0.0), (Blob("corners", b""),)))
    assert set(drawn.geom) == {1}
    assert len(drawn.corners) == 12


def test_cloud_of_a_surface_is_on_it_and_leaves_no_cell_out():
    """The surface is a square that is cut into slivers, whatever their shape."""
    ends = np.linspace(-0.5, 0.5, 40)
    low, high = np.full(40, -0.5), np.full(40, 0.5)
    rows = [np.stack([ends, side, 0.1 * ends], axis=1) for side in (low, high)]
    first = np.stack([rows[0][:-1], rows[0][1:], rows[1][:-1]], axis=1)
    second = np.stack([rows[0][1:], rows[1][1:], rows[1][:-1]], axis=1)
    shadows = shadow_casters(np.concatenate([first, second]).astype(np.float32))
    points = shadows.fine
    assert np.abs(points[:, 2] - 0.1 * points[:, 0]).max() < 1.1 * shadows.fine_pixel
    assert np.abs(points[:, :2]).max() < 0.5 + shadows.fine_pixel
    inside = np.abs(points[:, :2]).max(axis=1) < 0.49
    cells = {tuple(cell) for cell in np.floor(points[inside, :2] / shadows.fine_pixel).astype(int)}
    across = int(2 * 0.48 / shadows.fine_pixel)
    assert len(cells) > 0.98 * across**2


def test_cloud_has_a_point_for_each_triangle_at_least(monkeypatch):
    """Even of a robot with more triangles than the cloud should have points."""
    monkeypatch.setattr(light, "_MAX_POINTS", 100)
    points, cell = light._cloud(BALL.astype(np.float32), 0.01)
    assert len(points) == len(BALL) > 100
    assert cell > 0.01


def test_point_is_lit_where_nothing_is_on_its_way_to_the_lamp():
    """By a ball: a point is in its shadow where the line to the lamp passes its middle within the radius."""
    radius = 0.5
    ball = shadow_casters(solids.ellipsoid(np.full(3, radius)).astype(np.float32))
    random = np.random.default_rng(4)
    points = random.uniform(-0.9, 0.9, (4000, 3)) / np.sqrt(3)
    outside = points[np.linalg.norm(points, axis=1) > radius + 0.03]
    for lamp in (*key_lamps(np.array([0.6, 0.0, 0.8]), ball), *sky_lamps(ball)):
        along = outside @ lamp.direction
        passing = np.linalg.norm(outside - along[:, None] * lamp.direction, axis=1)
        clear = np.abs(passing - radius) > 0.04
        dark = (along < 0) & (passing < radius)
        single = np.ascontiguousarray(outside.T, dtype=np.float32)
        lit = lamp.reaches(single, np.zeros((2, len(outside)), np.float32), 1.5)
        assert (lit == ~dark)[clear].all()
        assert 50 < dark.sum() < len(dark) / 2


def test_lamps_have_their_power_and_are_above_the_ground():
    ball = shadow_casters(solids.ellipsoid(np.full(3, 0.5)).astype(np.float32))
    sky, key = sky_lamps(ball), key_lamps(np.array([0.6, 0.0, 0.8]), ball)
    assert all(lamp.direction[2] > 0.19 for lamp in sky)
    mean = sum(lamp.direction for lamp in key)
    assert mean / np.linalg.norm(mean) == pytest.approx([0.6, 0.0, 0.8], abs=0.02)
    assert [lamp.is_key for lamp in (*sky, *key)] == [False] * len(sky) + [True] * len(key)


SIZE = np.array([960, 720])
DIRECTIONS = [(0.7, -0.6, 0.4), (-1, 0.2, 0.1), (0, 0, 1), (0.3, 0.3, -0.9)]


def points(seed, size=1.0, at=(0.0, 0.0, 0.0)):
    random = np.random.default_rng(seed)
    return random.uniform(-1, 1, (40, 3)) * random.uniform(0.05, 1, 3) * size + at


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize(("seed", "size"), [(0, 1.0), (2, 0.005), (3, 50.0)])
def test_points_fill_the_picture_and_are_in_its_middle(direction, seed, size):
    cloud = points(seed, size, at=(3 * size, -size, 7 * size))
    places = framing(cloud, np.array(direction), *SIZE).projected(cloud)
    assert (places[:, 2] > 0).all()
    low, high = places[:, :2].min(axis=0), places[:, :2].max(axis=0)
    assert (np.abs(low + high - SIZE) <= 0.01 * SIZE + 40).all()
    shares = np.maximum(high - SIZE / 2, SIZE / 2 - low) / (SIZE / 2)
    assert shares.max() == pytest.approx(_MAX_FILLED_SHARE, rel=1e-9)
    # Along the axis that is filled both edges are touched.
    axis = shares.argmax()
    edges = SIZE[axis] * (1 - _MAX_FILLED_SHARE) / 2, SIZE[axis] * (1 + _MAX_FILLED_SHARE) / 2
    assert (low[axis], high[axis]) == pytest.approx(edges, abs=1e-6)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_ray_through_a_place_meets_the_point_that_is_seen_there(direction):
    cloud = points(5)
    camera = framing(cloud, np.array(direction), *SIZE)
    right, down, near = camera.projected(cloud).T
    assert camera.position + camera.rays(right, down) / near[:, None] == pytest.approx(cloud, abs=1e-9)


def test_up_is_up_and_a_turn_is_about_the_vertical():
    cube = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    camera = framing(cube, np.array([0.0, -1.0, 0.2]), *SIZE)
    assert (camera.position[1] < -1, camera.position[2] > 0) == (True, True)
    low, high, left, right = camera.projected(np.array([[0, 0, -1], [0, 0, 1], [-1, 0, 0], [1, 0, 0.0]]))
    assert (low[1] > high[1], left[0] < right[0]) == (True, True)
    assert np.linalg.det(camera.world_from_camera) == pytest.approx(1.0)
    assert turned_about_z(np.array([1.0, 0.0, 0.5]), np.pi / 2) == pytest.approx([0, 1, 0.5])
