"""Geoms, meshes and textures of an MJCF: what MuJoCo compiles is what our files have."""

import re
import struct

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats import png
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from tests.support.building import plan_of
from tests.support.mjcfs import body, bundle_of, model, robot_of, written
from tests.support.textures import (
    QUADRANTS,
    built,
    built_into,
    by_mujoco,
    by_trimesh,
    cube,
    image,
    obj,
    ordered,
    put,
)
from tests.support.textures import png as by_hand

pytestmark = pytest.mark.usefixtures("guests_at_home")

ASSETS = """<asset><texture name="four" type="2d" file="four.png"/>
<material name="painted" texture="four" rgba=".5 .75 1 1"/><mesh name="cube" file="cube.obj"{}/></asset>"""
GEOM = '<geom type="mesh" mesh="cube" {}/>'
SEEN = 'material="painted" contype="0" conaffinity="0"'


def source(folder, *geoms, assets="", picture=None):
    put(folder, **{"four.png": picture or image(), "cube.obj": obj(cube())})
    inside = "".join(geoms or [GEOM.format(SEEN)])
    world = f'<worldbody><body name="a">{inside}</body></worldbody>'
    text = f'<mujoco model="m">{assets or ASSETS.format("")}{world}</mujoco>'
    return {"kind": "mjcf", "path": str(written(folder, text))}


def pixels_of(folder, files):
    """The pixels of the compiled textures: ours and the original's."""
    return [
        mujoco.MjModel.from_xml_path(str(path)).tex_data for path in (folder / "robot.xml", files["path"])
    ]


def lost(files):
    robot, _, _, fetched = built(files)
    problems = (*fetched.diagnostics, *robot.diagnostics)
    return " ".join(problem.message for problem in problems if "MJCF-LEFT" in problem.code)


def placed(files):
    """The corners of the first geom's mesh in its body, as MuJoCo has them in the original."""
    model = mujoco.MjModel.from_xml_path(files["path"])
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[0])
    # MuJoCo moved the geom with the mesh, which `by_mujoco` moves back.
    back = np.zeros(9)
    mujoco.mju_quat2Mat(back, model.mesh_quat[0])
    points = by_mujoco(model, 0)
    local = (points[..., :3] - model.mesh_pos[0]) @ back.reshape(3, 3)
    points[..., :3] = local @ turn.reshape(3, 3).T + model.geom_pos[0]
    return points


def test_a_texture_keeps_its_coordinates_and_pixels(tmp_path):
    files = source(tmp_path / "source")
    robot, geometry, _ = built_into(tmp_path, files)
    (shape,) = geometry.shapes_of("a", "visual")
    assert shape.colour == (0.5, 0.75, 1.0, 1.0)
    assert np.allclose(ordered(by_trimesh(tmp_path / "assets" / "a.obj")), ordered(cube()), atol=2e-6)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert np.allclose(ordered(by_mujoco(model, 0)), ordered(cube()), atol=2e-6)
    assert model.ntex == 1
    ours, theirs = pixels_of(tmp_path, files)
    assert np.array_equal(ours, theirs)
    pixels = ours.reshape(4, 4, 3)
    assert [tuple(pixels[row, column]) for row in (0, 3) for column in (0, 3)] == list(QUADRANTS)
    assert (tmp_path / "robot.urdf").read_text().count("<texture ") == 1
    assert "texture" not in lost(files)
    assert robot.name == "robot"


@pytest.mark.parametrize("scale", ["1 -2 1", "-1 -1 -1", "2 2 2"])
def test_scaled_and_mirrored_meshes_are_as_mujoco_has_them(tmp_path, scale):
    files = source(
        tmp_path / "source",
        GEOM.format(f'{SEEN} pos="0 0 1" euler="30 0 40"'),
        assets=ASSETS.format(f' scale="{scale}"'),
    )
    built_into(tmp_path, files)
    points = by_trimesh(tmp_path / "assets" / "a.obj")
    assert np.allclose(ordered(np.round(points, 4)), ordered(np.round(placed(files), 4)), atol=2e-4)


def test_coordinates_in_the_file_and_a_texture_that_mujoco_makes(tmp_path):
    corners = "0 0 0 1 0 0 0 1 0 0 0 1"
    assets = f"""<asset><mesh name="cube" vertex="{corners}" texcoord="0 0 1 0 0 1 1 1"/>
    <texture name="check" type="2d" builtin="checker" width="8" height="8" rgb1="1 0 0" rgb2="0 1 0"/>
    <material name="painted" texture="check"/></asset>"""
    files = source(tmp_path / "source", assets=assets)
    built_into(tmp_path, files)
    assert np.allclose(ordered(by_trimesh(tmp_path / "assets" / "a.obj")), ordered(placed(files)), atol=1e-6)
    assert np.array_equal(*pixels_of(tmp_path, files))


def test_a_geoms_own_colour_is_times_the_image(tmp_path):
    files = source(tmp_path, GEOM.format(f'{SEEN} rgba="1 0 0 1"'), GEOM.format(SEEN))
    _, geometry, _, _ = built(files)
    shapes = geometry.shapes_of("a", "visual")
    assert {shape.colour for shape in shapes} == {(1.0, 0.0, 0.0, 1.0), (0.5, 0.75, 1.0, 1.0)}
    assert len({shape.texture for shape in shapes}) == 1


BOX = '<geom size=".1 .1 .1" type="box" material="painted" contype="0" conaffinity="0" mass="1"/>'


@pytest.mark.parametrize(
    ("geom", "assets"),
    [
        (BOX, ""),
        ("", '<texture name="four" type="cube" builtin="flat" width="4" height="4"/>'),
        ("", '<mesh name="cube" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>'),
    ],
)
def test_a_texture_without_coordinates_is_named(tmp_path, geom, assets):
    whole = ASSETS.format("")
    if assets:
        whole = re.sub(assets.split()[0] + ".*?/>", assets, whole, count=1, flags=re.DOTALL)
    files = source(tmp_path, *([geom] if geom else []), assets=whole)
    _, geometry, _, _ = built(files)
    assert [shape.texture for shape in geometry.shapes_of("a", "visual") if shape.file] in ([], [None])
    text = lost(files)
    assert "1 × material texture (painted)" in text
    assert "1 × texture (four)" in text
    # Where only one of two geoms loses it, the material is named and the texture is not.
    text = lost(source(tmp_path, BOX, GEOM.format(SEEN))) if geom else "material texture (painted)"
    assert ("material texture (painted)" in text, "texture (four)" in text) == (True, False)


def test_a_collider_that_is_not_seen_needs_no_texture(tmp_path):
    files = source(tmp_path, GEOM.format('material="painted" group="3"'), GEOM.format(SEEN))
    _, geometry, _, fetched = built(files)
    assert len(geometry.shapes_of("a", "visual")) == 1
    assert len([request for request in fetched.bundle.requests if request.startswith("mesh/")]) == 2


@pytest.mark.parametrize("colour", [0, 2, 6])
def test_images_of_any_kind_are_the_pixels_that_mujoco_has(tmp_path, colour):
    channels = {0: 1, 2: 3, 6: 4}[colour]
    pixels = np.random.default_rng(colour).integers(0, 256, (6, 4, channels), dtype=np.uint8)
    picture = by_hand(4, 6, [row.tobytes() for row in pixels], colour=colour)
    files = source(tmp_path / "source", picture=picture)
    built_into(tmp_path, files)
    ours, theirs = pixels_of(tmp_path, files)
    assert np.array_equal(ours, theirs)
    assert len(ours) == 6 * 4 * 3


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_a_png_of_ours_has_its_pixels(channels):
    pixels = np.random.default_rng(channels).integers(0, 256, (5, 7, channels), dtype=np.uint8)
    data = png.encode(pixels)
    assert png.problem(data) == ""
    texture = f'<texture name="t" type="2d" file="t.png" nchannel="{channels}"/>'
    text = f"<mujoco><asset>{texture}</asset></mujoco>"
    model = mujoco.MjModel.from_xml_string(text, assets={"t.png": data})
    assert np.array_equal(model.tex_data.reshape(pixels.shape), pixels)


GEOMS = """<geom type="box" size=".1 .2 .3" rgba=".8 .1 .2 1" contype="0" conaffinity="0" group="2"/>
  <geom type="sphere" size=".1" pos="0 0 1"/><geom type="capsule" size=".1 .2" group="3"/>
  <geom type="cylinder" fromto="0 0 0 0 0 .6" size=".05" rgba="1 1 1 0"/>
  <geom type="ellipsoid" size=".1 .2 .3"/>"""


def test_geoms_are_seen_or_touched_as_the_file_has_them(tmp_path):
    tip = body("tip", '<geom size=".2"/>')
    world = '<geom name="floor" type="plane" size="1 1 1"/>' + body("base", GEOMS + tip)
    robot = robot_of(written(tmp_path, model(world)))
    shapes = [(shape.kind, shape.size, shape.visual, shape.collision) for shape in robot.root.shapes]
    assert shapes == [
        ("box", (0.2, 0.4, 0.6), True, False),
        ("sphere", (0.1,), False, True),
        ("capsule", (0.1, 0.4), False, True),
        ("cylinder", (0.05, pytest.approx(0.6)), False, True),
    ]
    assert robot.root.shapes[0].colour == (0.8, 0.1, 0.2, 1.0)
    assert [(shape.visual, shape.collision) for shape in robot.link("tip").shapes] == [(True, True)]
    messages = {diagnostic.code: diagnostic.message for diagnostic in robot.diagnostics}
    assert "1 geom of the world" in messages["I-MJCF-SCENE"]
    (ellipsoid,) = robot.root.parts
    assert (ellipsoid.form.ellipsoid, ellipsoid.collides) == ((0.2, 0.4, 0.6), True)


@pytest.mark.parametrize(("group", "seen"), [(0, True), (1, False)])
def test_a_collider_is_seen_beside_a_visual_of_its_group(group, seen, tmp_path):
    """A ring around an arm that collides is drawn with it; a mesh in another group is drawn instead of it."""
    ring = f'<geom type="cylinder" size=".05 .01" contype="0" conaffinity="0" group="{group}"/>'
    robot = robot_of(written(tmp_path, model(body("base", ring + '<geom type="capsule" size=".03 .2"/>'))))
    shapes = [(shape.kind, shape.visual, shape.collision) for shape in robot.root.shapes]
    assert shapes == [("cylinder", True, False), ("capsule", seen, True)]


CORNERS = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.1]], dtype="<f4") + np.float32(0.125)


FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def stl():
    rows = [struct.pack("<3f", 0, 0, 0) + CORNERS[list(face)].tobytes() + b"\0\0" for face in FACES]
    return b"\0" * 80 + struct.pack("<I", len(FACES)) + b"".join(rows)


def test_a_mesh_lies_where_the_file_puts_it(tmp_path):
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / "wedge.stl").write_bytes(stl())
    world = body("base", '<geom type="mesh" mesh="wedge" pos="1 2 3" quat="1 1 0 0" material="red"/>')
    asset = """<asset><mesh name="wedge" file="wedge.stl" scale="2 1 -1" refpos=".1 .2 .3" refquat="1 0 0 1"/>
        <material name="red" rgba="1 0 0 1"/></asset>"""
    path = written(tmp_path, model(world, asset, compiler='meshdir="assets"'))
    bundle = bundle_of(path)
    robot = build_robot(bundle, plan_of())
    (part,) = robot.root.parts
    made = body_arrays.decode(bundle.body(part.mesh.reply))[part.mesh.part]
    assert made.palette == ((1.0, 0.0, 0.0, 1.0),)
    points = made.points @ part.world_from_part[:3, :3].T + part.world_from_part[:3, 3]
    # The mesh's frame in its file is at refpos, turned by 90° about z; the scale is along its axes.
    turned = (CORNERS - [0.1, 0.2, 0.3]) @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]).T
    placed = turned * [2.0, 1.0, -1.0]
    wanted = placed @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]).T + [1, 2, 3]
    distance = np.linalg.norm(points[:, None] - wanted, axis=-1)
    assert distance.min(axis=0).max() < 1e-6
    assert distance.min(axis=1).max() < 1e-6
    geometry = make_geometry(robot, bundle, plan_of(), lambda kind, key, make: make())
    visual = next(shape for shape in geometry.shapes if shape.role == "visual")
    assert visual.volume == pytest.approx(2 * 0.3 * 0.2 * 0.1 / 6, rel=1e-5)


def test_a_visual_is_kept_though_the_file_discards_it(tmp_path):
    shape = '<geom size=".1" contype="0" conaffinity="0"/>'
    path = written(tmp_path, model(body("base", shape), compiler='discardvisual="true"'))
    assert [(shape.visual, shape.collision) for shape in robot_of(path).root.shapes] == [(True, False)]
