"""The pictures of links: the right pixels, in the right colours, within bounds."""

import base64
import colorsys
import json
import struct
import zlib
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
from linkwright.stages.show.raster import drawn, work
from tests.support.solids import box

WHITE = np.array([255, 255, 255], dtype=np.uint8)
BACKGROUND = tuple(room._BACKGROUND.tolist())


def inside(corners, x, y):
    """Whether (x, y) is in a triangle, by the signs of three cross products; None too near an edge to say."""
    signs = []
    for (ax, ay, _), (bx, by, _) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        cross = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
        if abs(cross) < 1e-6 * max(1.0, np.hypot(bx - ax, by - ay)):
            return None
        signs.append(cross > 0)
    return all(signs) or not any(signs)


def height(corners, x, y):
    """How near the viewer a triangle is at (x, y), by a linear system."""
    rows = np.column_stack([corners[:, :2], np.ones(3)])
    return float(np.array([x, y, 1.0]) @ np.linalg.solve(rows, corners[:, 2]))


@pytest.mark.parametrize("seed", range(2))
def test_each_pixel_shows_the_triangle_that_is_nearest_there(seed):
    random, side = np.random.default_rng(seed), 16
    corners = random.uniform(-4, side + 4, (14, 3, 3))
    colours = np.arange(14 * 3, dtype=np.uint8).reshape(14, 3)
    found = drawn(corners, colours, WHITE, side)
    checked = 0
    for row in range(side):
        for column in range(side):
            x, y = column + 0.5, row + 0.5
            within = [inside(one, x, y) for one in corners]
            if None in within:
                continue
            there = [(height(corners[i], x, y), i) for i, yes in enumerate(within) if yes]
            heights = sorted(at for at, _ in there)
            if len(heights) > 1 and heights[-1] - heights[-2] < 1e-3:
                continue
            expected = colours[max(there)[1]] if there else WHITE
            assert found[row, column].tolist() == expected.tolist()
            checked += 1
    assert checked > 0.9 * side * side


def test_the_order_of_the_triangles_does_not_matter_nor_how_many_are_drawn_at_once(monkeypatch):
    random = np.random.default_rng(5)
    corners = random.uniform(0, 40, (60, 3, 3))
    colours = random.integers(0, 255, (60, 3)).astype(np.uint8)
    whole = drawn(corners, colours, WHITE, 40)
    order = random.permutation(60)
    monkeypatch.setattr("linkwright.stages.show.raster._AT_ONCE", 500)
    assert np.array_equal(drawn(corners[order], colours[order], WHITE, 40), whole)
    assert np.array_equal(drawn(np.zeros((0, 3, 3)), colours[:0], WHITE, 2), np.full((2, 2, 3), 255))


def test_triangles_that_meet_leave_no_gap():
    """A disc in many thin triangles covers the pixels of one square in two."""
    turns = np.linspace(0, 2 * np.pi, 400)
    rim = np.column_stack([20 + 60 * np.cos(turns), 20 + 60 * np.sin(turns), np.zeros(400)])
    fan = np.stack([np.broadcast_to([20.0, 20, 0], (399, 3)), rim[:-1], rim[1:]], axis=1)
    assert (drawn(fan, np.zeros((399, 3), dtype=np.uint8), WHITE, 40) == 0).all()


def pixels_of(data):
    """(height, width, 3) of a PNG whose rows are differences from those above."""
    assert png.problem(data) == ""
    width, height_ = struct.unpack_from(">II", data, 16)
    (length,) = struct.unpack_from(">I", data, 33)
    rows = np.frombuffer(zlib.decompress(data[41 : 41 + length]), np.uint8).reshape(height_, 1 + 3 * width)
    assert (rows[:, 0] == 2).all()
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(height_, width, 3)


def mesh(name, role, surface, colour=None):
    return Shape("arm", role, name, colour, len(surface.vertices), len(surface.triangles), 0.0, 0.0)


def ball(role, radius, colour=None):
    return Shape("arm", role, None, colour, 0, 0, 0.0, 0.0, Primitive("sphere", (radius,), frozen(np.eye(4))))


def test_what_is_seen_is_on_the_left_and_its_collider_on_the_right_in_one_scale():
    red = (1.0, 0.0, 0.0, 1.0)
    found = pixels_of(picture([ball("collision", 0.1), ball("visual", 0.05, red)], {}))
    assert found.shape == (SIDE, 2 * SIDE, 3)
    left, right = found[:, :SIDE], found[:, SIDE:]
    full = (SIDE * 0.9) / 2
    for half, radius in ((left, full / 2), (right, full)):
        number = (half != BACKGROUND).any(axis=2).sum()
        assert number == pytest.approx(np.pi * radius**2, rel=0.03)
        rows, columns = np.nonzero((half != BACKGROUND).any(axis=2))
        assert (rows.mean(), columns.mean()) == pytest.approx((SIDE / 2, SIDE / 2), abs=1.5)
    assert (left[SIDE // 2, SIDE // 2, 0] > 3 * left[SIDE // 2, SIDE // 2, 1:]).all()
    # Lit from above.
    assert left[int(SIDE / 2 - full / 4), SIDE // 2, 0] > left[int(SIDE / 2 + full / 4), SIDE // 2, 0]


def test_above_is_above_and_what_is_in_front_hides_what_is_behind():
    low, high = box(0.1, 0.1, 0.1), box(0.04, 0.04, 0.3, at=(0, 0, 0.2))
    behind = box(0.08, 0.08, 0.08)
    files = {"a.stl": stl.write(low), "b.stl": stl.write(high), "c.stl": stl.write(behind)}
    shapes = [
        mesh("a.stl", "visual", low, (1, 0, 0, 1)),
        mesh("b.stl", "visual", high, (0, 0, 1, 1)),
        mesh("c.stl", "visual", behind, (0, 1, 0, 1)),
    ]
    left = pixels_of(picture(shapes, files))[:, :SIDE].astype(int)
    red, blue = (np.nonzero(left[:, :, one] > 2 * left[:, :, 2 - one])[0] for one in (0, 2))
    assert red.mean() > blue.mean() + SIDE / 4
    assert not (left[:, :, 1] > left[:, :, 0] + left[:, :, 2]).any()


def test_each_collider_has_a_colour_of_its_own():
    shapes = [
        Shape("arm", "collision", None, None, 0, 0, 0.0, 0.0, Primitive("box", (0.02,) * 3, at(0.05 * place)))
        for place in range(6)
    ]
    right = pixels_of(picture(shapes, {}))[:, SIDE:]
    # The colours at a border are mixed with the background's.
    counts = Counter(map(tuple, right.reshape(-1, 3).tolist()))
    often = {one for one, number in counts.items() if number > 20} - {BACKGROUND}
    assert len({round(colorsys.rgb_to_hls(*(c / 255 for c in one))[0], 1) for one in often}) >= 5


def at(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return frozen(pose)


BLOCK = box(0.1, 0.06, 0.02)
SHAPES = (
    mesh("arm_collision.stl", "collision", BLOCK),
    mesh("arm.stl", "visual", BLOCK, (0.2, 0.5, 0.9, 1.0)),
)
FILES = {"arm_collision.stl": stl.write(BLOCK), "arm.stl": stl.write(BLOCK)}


def again(kind, key, make):
    return make()


def table(geometry, memo=again):
    return json.loads(views(geometry, memo)[PICTURES])


def test_an_obj_gives_the_same_picture_as_an_stl():
    plain = picture(SHAPES, FILES)
    textured = with_texcoords(BLOCK)
    dressed = obj.with_material(obj.write(textured), "a.mtl", "m")
    for data in (obj.write(BLOCK), dressed):
        shapes = [SHAPES[0], replace(SHAPES[1], file="arm.obj")]
        assert picture(shapes, {**FILES, "arm.obj": data}) == plain


def with_texcoords(surface):
    texcoords = np.zeros((len(surface.triangles), 3, 2), dtype=np.float32)
    return Surface(surface.vertices, surface.triangles, texcoords)


def links(*names):
    """A geometry with the block for each link."""
    return judged(tuple(replace(shape, link=name) for name in names for shape in SHAPES), FILES)


def judged(shapes, files):
    """A geometry whose links all have colliders that are within their tolerance."""
    links = dict.fromkeys(shape.link for shape in shapes)
    one = ColliderFigures("", ("P",), "ladder", "hull", 1, 8, True, 0.001, None)
    return Geometry(shapes, files, colliders=tuple(replace(one, link=link) for link in links))


def test_the_pictures_are_in_the_order_of_the_links_and_made_once_for_equal_ones():
    kept = {}

    def memo(kind, key, make):
        name = json.dumps([kind, key])
        if name not in kept:
            kept[name] = make()
        return kept[name]

    found = table(links("b", "a"), memo)
    assert [one["link"] for one in found["pictures"]] == ["b", "a"]
    assert (found["left_out"], found["side"], len(kept)) == ([], SIDE, 1)
    assert {base64.b64decode(one["png"]) for one in found["pictures"]} == set(kept.values())
    other = replace(SHAPES[1], colour=(1.0, 0.0, 0.0, 1.0))
    views(judged((SHAPES[0], other), FILES), memo)
    assert len(kept) == 2


def test_links_that_miss_come_first_where_there_is_no_room_for_all(monkeypatch):
    one = len(picture(SHAPES, FILES))
    monkeypatch.setattr(room, "MOST_BYTES", 2 * one)
    missing = ColliderFigures("c", ("P",), "ladder", "hull", 1, 8, False, 0.001, None)
    every = links("a", "b", "c")
    found = table(replace(every, colliders=(*every.colliders, missing)))
    assert [one["link"] for one in found["pictures"]] == ["a", "c"]
    assert found["left_out"] == ["b"]


def test_what_would_take_too_long_to_draw_is_left_out_before_it_is_drawn(monkeypatch):
    random = np.random.default_rng(2)
    wild = Surface(random.uniform(-1, 1, (150_000, 3)), np.arange(150_000).reshape(-1, 3))
    files = {"arm_collision.stl": FILES["arm_collision.stl"], "arm.stl": stl.write(wild)}
    monkeypatch.setattr(room, "drawn", lambda *_: pytest.fail("it was drawn"))
    found = table(judged(SHAPES, files))
    assert (found["pictures"], found["left_out"]) == ([], ["arm"])


def test_the_work_is_no_less_than_the_pixels_of_all_triangles():
    corners = np.random.default_rng(3).uniform(0, 30, (40, 3, 3))
    black = np.zeros((1, 3), dtype=np.uint8)
    covered = [(drawn(one[None], black, WHITE, 30) == 0).all(axis=2).sum() for one in corners]
    assert sum(covered) < work(corners) < 12 * sum(covered)


@pytest.mark.parametrize(
    "geometry",
    [
        judged((), {}),
        judged(SHAPES[1:], FILES),
        judged(SHAPES, {}),
        Geometry(SHAPES, FILES),
    ],
    ids=["nothing", "no collider", "no files", "not judged"],
)
def test_nothing_is_drawn_where_no_collider_was_judged_or_meshes_are_left_out(geometry):
    assert views(geometry, again) == {}


@pytest.mark.parametrize(
    "points",
    [np.zeros((3, 3)), np.full((3, 3), np.nan), np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]])],
    ids=["a point", "not a number", "a line"],
)
def test_degenerate_meshes_harm_no_picture(points):
    surface = Surface(points.astype(float), np.array([[0, 1, 2]]))
    data = picture([mesh("a.stl", "visual", surface, None)], {"a.stl": stl.write(surface)})
    assert data == b"" or png.problem(data) == ""


def test_a_fine_mesh_is_drawn_from_its_own_triangles():
    """As a ball of 20,000 triangles looks like the primitive."""
    fine = trimesh.creation.icosphere(5, 0.1)
    surface = Surface(np.asarray(fine.vertices, dtype=float), np.asarray(fine.faces, dtype=np.int64))
    data = picture([mesh("a.stl", "visual", surface)], {"a.stl": stl.write(surface)})
    shown, plain = pixels_of(data), pixels_of(picture([ball("visual", 0.1)], {}))
    differ = (shown != BACKGROUND).any(axis=2) ^ (plain != BACKGROUND).any(axis=2)
    assert differ.mean() < 0.01
