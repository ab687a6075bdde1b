"""The pictures of links: the right pixels, in the right colours, within bounds."""

import base64
import colorsys
import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from linkwright.stages.formats import png
from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.files import obj, stl
from linkwright.stages.mesh.view import pictures as room
from linkwright.stages.mesh.view.pictures import SIDE, picture
from linkwright.stages.mesh.view.views import PICTURES, views
from linkwright.stages.robot.model.geometry import ColliderFigures, Geometry, Shape
from linkwright.stages.robot.model.robot import Primitive, frozen
from linkwright.stages.show.raster import picture_of_triangles, work
from tests.support.pictures import pixels_of
from tests.support.robots import at
from tests.support.solids import box, of_mesh
from tests.support.touching import Memory, no_memo

WHITE = np.array([255, 255, 255], dtype=np.uint8)
BACKGROUND = tuple(room._BACKGROUND.tolist())


def inside(corners, x, y):
    """Whether (x, y) is in a triangle, by the signs of three cross products; None if too near an edge."""
    ahead = np.roll(corners, -1, axis=0)[:, :2] - corners[:, :2]
    away = np.array([x, y]) - corners[:, :2]
    cross = ahead[:, 0] * away[:, 1] - ahead[:, 1] * away[:, 0]
    if (np.abs(cross) < 1e-6 * np.maximum(1.0, np.hypot(*ahead.T))).any():
        return None
    return bool((cross > 0).all() or (cross < 0).all())


def height(corners, x, y):
    """How near the viewer a triangle is at (x, y), by a linear system."""
    rows = np.column_stack([corners[:, :2], np.ones(3)])
    return float(np.array([x, y, 1.0]) @ np.linalg.solve(rows, corners[:, 2]))


@pytest.mark.parametrize("seed", range(2))
def test_each_pixel_shows_the_triangle_that_is_nearest_there(seed):
    random, side = np.random.default_rng(seed), 16
    corners = random.uniform(-4, side + 4, (14, 3, 3))
    colours = np.arange(14 * 3, dtype=np.uint8).reshape(14, 3)
    image = picture_of_triangles(corners, colours, WHITE, side)
    checked = 0
    for row, column in np.ndindex(side, side):
        x, y = column + 0.5, row + 0.5
        within = [inside(corner, x, y) for corner in corners]
        there = sorted((height(corners[i], x, y), i) for i, yes in enumerate(within) if yes)
        if None in within or (len(there) > 1 and there[-1][0] - there[-2][0] < 1e-3):
            continue
        expected = colours[there[-1][1]] if there else WHITE
        assert image[row, column].tolist() == expected.tolist()
        checked += 1
    assert checked > 0.9 * side * side


def test_neither_order_nor_number_of_triangles_at_once_matters(monkeypatch):
    random = np.random.default_rng(5)
    corners = random.uniform(0, 40, (60, 3, 3))
    colours = random.integers(0, 255, (60, 3)).astype(np.uint8)
    whole = picture_of_triangles(corners, colours, WHITE, 40)
    order = random.permutation(60)
    monkeypatch.setattr("linkwright.stages.show.raster._MAX_BATCH", 500)
    assert np.array_equal(picture_of_triangles(corners[order], colours[order], WHITE, 40), whole)
    assert np.array_equal(
        picture_of_triangles(np.zeros((0, 3, 3)), colours[:0], WHITE, 2), np.full((2, 2, 3), 255)
    )


def test_triangles_that_meet_leave_no_gap():
    """A disc in many thin triangles covers the pixels of one square in two."""
    turns = np.linspace(0, 2 * np.pi, 400)
    rim = np.column_stack([20 + 60 * np.cos(turns), 20 + 60 * np.sin(turns), np.zeros(400)])
    fan = np.stack([np.broadcast_to([20.0, 20, 0], (399, 3)), rim[:-1], rim[1:]], axis=1)
    assert (picture_of_triangles(fan, np.zeros((399, 3), dtype=np.uint8), WHITE, 40) == 0).all()


def shape(role, primitive=None, colour=None, name=None):
    return Shape("arm", role, name, colour, 0, 0, 0.0, 0.0, primitive)


def ball(radius):
    return Primitive("sphere", (radius,), frozen(np.eye(4)))


def test_visuals_are_left_and_colliders_right_in_one_scale():
    shapes = [shape("collision", ball(0.1)), shape("visual", ball(0.05), (1.0, 0.0, 0.0, 1.0))]
    image = pixels_of(picture(shapes, {}))
    assert image.shape == (SIDE, 2 * SIDE, 3)
    left, right = image[:, :SIDE], image[:, SIDE:]
    full, middle = (SIDE * 0.9) / 2, SIDE // 2
    for half, radius in ((left, full / 2), (right, full)):
        coloured = (half != BACKGROUND).any(axis=2)
        assert coloured.sum() == pytest.approx(np.pi * radius**2, rel=0.03)
        assert np.argwhere(coloured).mean(axis=0) == pytest.approx((SIDE / 2, SIDE / 2), abs=1.5)
    assert (left[middle, middle, 0] > 3 * left[middle, middle, 1:]).all()
    # Lit from above.
    assert left[int(SIDE / 2 - full / 4), middle, 0] > left[int(SIDE / 2 + full / 4), middle, 0]


def test_above_is_above_and_the_front_hides_what_is_behind():
    surfaces = box(0.1, 0.1, 0.1), box(0.04, 0.04, 0.3, at=(0, 0, 0.2)), box(0.08, 0.08, 0.08)
    colours = (1, 0, 0, 1), (0, 0, 1, 1), (0, 1, 0, 1)
    files = {f"{number}.stl": stl.write(surface) for number, surface in enumerate(surfaces)}
    shapes = [shape("visual", None, colour, f"{number}.stl") for number, colour in enumerate(colours)]
    left = pixels_of(picture(shapes, files))[:, :SIDE].astype(int)
    red, blue = (np.nonzero(left[:, :, channel] > 2 * left[:, :, 2 - channel])[0] for channel in (0, 2))
    assert red.mean() > blue.mean() + SIDE / 4
    assert not (left[:, :, 1] > left[:, :, 0] + left[:, :, 2]).any()


def test_each_collider_has_a_colour_of_its_own():
    cubes = [Primitive("box", (0.02,) * 3, frozen(at(0.05 * place, 0, 0))) for place in range(6)]
    right = pixels_of(picture([shape("collision", cube) for cube in cubes], {}))[:, SIDE:]
    # The colours at a border are mixed with the background's.
    counts = Counter(map(tuple, right.reshape(-1, 3).tolist()))
    often = {colour for colour, number in counts.items() if number > 20} - {BACKGROUND}
    assert len({round(colorsys.rgb_to_hls(*(c / 255 for c in colour))[0], 1) for colour in often}) >= 5


BLOCK = box(0.1, 0.06, 0.02)
SHAPES = (
    shape("collision", name="arm_collision.stl"),
    shape("visual", colour=(0.2, 0.5, 0.9, 1.0), name="arm.stl"),
)
FILES = {"arm_collision.stl": stl.write(BLOCK), "arm.stl": stl.write(BLOCK)}
FIGURES = ColliderFigures("", ("P",), "ladder", "hull", 1, 8, True, 0.001, None)


def table(geometry, memo=no_memo):
    return json.loads(views(geometry, memo)[PICTURES])


def test_obj_gives_the_same_picture_as_an_stl():
    texcoords = np.zeros((len(BLOCK.triangles), 3, 2), dtype=np.float32)
    textured = obj.write(Surface(BLOCK.vertices, BLOCK.triangles, texcoords))
    for data in (obj.write(BLOCK), obj.with_material(textured, "a.mtl", "m")):
        shapes = [SHAPES[0], replace(SHAPES[1], file="arm.obj")]
        assert picture(shapes, {**FILES, "arm.obj": data}) == picture(SHAPES, FILES)


def judged(shapes, files):
    """A geometry whose links all have colliders that are within their tolerance."""
    links = dict.fromkeys(shape.link for shape in shapes)
    return Geometry(shapes, files, colliders=tuple(replace(FIGURES, link=link) for link in links))


def links(*names):
    """A geometry with the block for each link."""
    return judged(tuple(replace(shape, link=name) for name in names for shape in SHAPES), FILES)


def test_pictures_are_in_order_and_made_once_for_equal_links():
    memo = Memory()
    pictures = table(links("b", "a"), memo)
    assert [entry["link"] for entry in pictures["pictures"]] == ["b", "a"]
    assert (pictures["left_out"], pictures["side"], memo.made) == ([], SIDE, 1)
    assert {base64.b64decode(entry["png"]) for entry in pictures["pictures"]} == set(memo.kept.values())
    views(judged((SHAPES[0], replace(SHAPES[1], colour=(1.0, 0.0, 0.0, 1.0))), FILES), memo)
    assert memo.made == 2


def test_links_that_miss_come_first_where_room_is_short(monkeypatch):
    monkeypatch.setattr(room, "MAX_BYTES", 2 * len(picture(SHAPES, FILES)))
    geometry = links("a", "b", "c")
    missing = replace(FIGURES, link="c", meets=False)
    pictures = table(replace(geometry, colliders=(*geometry.colliders, missing)))
    assert [entry["link"] for entry in pictures["pictures"]] == ["a", "c"]
    assert pictures["left_out"] == ["b"]


def test_links_that_take_too_long_are_left_out_undrawn(monkeypatch):
    corners = np.random.default_rng(2).uniform(-1, 1, (150_000, 3))
    wild = stl.write(Surface(corners, np.arange(150_000).reshape(-1, 3)))
    monkeypatch.setattr(room, "picture_of_triangles", lambda *_: pytest.fail("it was drawn"))
    pictures = table(judged(SHAPES, {**FILES, "arm.stl": wild}))
    assert (pictures["pictures"], pictures["left_out"]) == ([], ["arm"])


def test_work_is_no_less_than_the_pixels_of_all_triangles():
    corners = np.random.default_rng(3).uniform(0, 30, (40, 3, 3))
    black = np.zeros((1, 3), dtype=np.uint8)
    covered = sum(
        (picture_of_triangles(corner[None], black, WHITE, 30) == 0).all(axis=2).sum() for corner in corners
    )
    assert covered < work(corners) < 12 * covered


@pytest.mark.parametrize(
    "geometry",
    [judged((), {}), judged(SHAPES[1:], FILES), judged(SHAPES, {}), Geometry(SHAPES, FILES)],
    ids=["nothing", "no collider", "no files", "not judged"],
)
def test_nothing_is_drawn_without_a_judged_collider_or_meshes(geometry):
    assert views(geometry, no_memo) == {}


@pytest.mark.parametrize(
    "points",
    [np.zeros((3, 3)), np.full((3, 3), np.nan), np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])],
    ids=["a point", "not a number", "a line"],
)
def test_degenerate_meshes_harm_no_picture(points):
    data = stl.write(Surface(points, np.array([[0, 1, 2]])))
    image = picture([shape("visual", name="a.stl")], {"a.stl": data})
    assert image == b"" or png.problem(image) == ""


def test_fine_mesh_is_drawn_from_its_own_triangles():
    files = {"a.stl": stl.write(of_mesh(trimesh.creation.icosphere(5, 0.1)))}
    images = picture([shape("visual", name="a.stl")], files), picture([shape("visual", ball(0.1))], {})
    fine, plain = ((pixels_of(image) != BACKGROUND).any(axis=2) for image in images)
    assert (fine ^ plain).mean() < 0.01
