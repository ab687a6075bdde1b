"""The picture shows the robot: where, how large, in which colour, and as MuJoCo's own camera sees it."""

from functools import cache

import mujoco
import numpy as np
import pytest
import trimesh

from linkwright.stages.formats import png
from linkwright.stages.show.preview.camera import framing
from linkwright.stages.show.preview.compiled import look_of
from linkwright.stages.show.preview.drawing.painting import draw_picture, render
from linkwright.stages.show.preview.drawing.studio import studio, swept_points, turned_by
from linkwright.stages.show.preview.surface import surface_of
from linkwright.stages.show.raster import nearest_triangles
from tests.support.other_robots import FILES, is_here
from tests.support.pictures import robot_in, silhouette_by_driver

SIZE = 320, 240
RED, GREEN, BLUE, YELLOW = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0)

ARM = """
<mujoco>
  <default><geom rgba="0.9 0.1 0.1 1" contype="0" conaffinity="0"/></default>
  <asset>
    <mesh name="wedge" vertex="0 0 0 {s2} 0 0 0 {s2} 0 0 0 {s3} {s2} {s2} 0" scale="1 1 1"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1" rgba="0 1 0 1" contype="1"/>
    <body pos="0 0 {s1}">
      {free}
      <geom type="box" size="{s2} {s2} {s1}"/>
      <body pos="0 0 {s1}">
        <joint name="shoulder" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 {s3} 0 {s2}" size="{s1}"/>
        <geom type="ellipsoid" size="{s1} {s2} {s1}" pos="{s3} 0 {s2}"/>
        <geom type="cylinder" size="{s1} {s2}" pos="{s3} 0 {s3}"/>
        <geom type="mesh" mesh="wedge" pos="0 0 {s3}"/>
      </body>
    </body>
    <geom type="sphere" size="{s1}" pos="0 {s3} {s1}" contype="1" conaffinity="1" group="3"/>
  </worldbody>
  {home}
</mujoco>
"""
FREE = "<freejoint/>"


def arm(size=1.0, free="", home='<keyframe><key name="home" qpos="-0.4"/></keyframe>'):
    """A robot of every shape, about `size` large [m], which is red; the floor and a collider are not it."""
    return ARM.format(s1=0.1 * size, s2=0.2 * size, s3=0.5 * size, free=free, home=home)


def scene_of(model, values=None):
    look = look_of(model, values or {})
    return studio(surface_of(look), np.array(look.backward))


@cache
def shown(xml):
    return draw_picture(scene_of(mujoco.MjModel.from_xml_string(xml)), *SIZE)


@pytest.mark.parametrize(
    "xml", [arm(), arm(0.01), arm(100.0), arm(free=FREE, home="")], ids=["1 m", "10 mm", "100 m", "floats"]
)
def test_robot_is_in_the_middle_in_its_colour_and_large(xml):
    pixels = shown(xml)
    robot = robot_in(pixels)
    assert 0.05 < robot.mean() < 0.6
    rows, columns = np.nonzero(robot)
    for places, across in ((rows, SIZE[1]), (columns, SIZE[0])):
        assert places.min() > 0.04 * across
        assert places.max() < 0.96 * across
        assert places.min() + places.max() == pytest.approx(across, abs=0.08 * across)
    red, green, blue = np.median(pixels[robot], axis=0)
    assert red > 1.6 * max(green, blue)
    # The ground is calm and light, but for the shadow.
    ground = pixels[~robot].astype(int)
    assert (ground.max(axis=1) - ground.min(axis=1) < 26).all()
    assert np.median(ground) > 220
    corners = pixels[[0, 0, -1, -1], [0, -1, 0, -1]].astype(int)
    assert np.ptp(corners, axis=0).max() < 30


def test_robot_of_any_size_has_the_same_picture():
    small, large = (shown(arm(size)).astype(int) for size in (0.01, 100.0))
    assert (np.abs(small - large).max(axis=2) > 12).mean() < 0.005


def test_picture_is_taken_at_home_or_at_other_values():
    at_home = shown(arm())
    without = mujoco.MjModel.from_xml_string(arm(home=""))
    placed = draw_picture(scene_of(without, {"shoulder": -0.4, "other": 1.0}), *SIZE)
    assert np.array_equal(at_home, placed)
    assert not np.array_equal(at_home, shown(arm(home="")))


def test_scenes_own_camera_says_from_where():
    camera = '<camera name="overview" pos="-9 0 2" xyaxes="0 -1 0 0.2 0 1"/></worldbody>'
    behind = shown(arm().replace("</worldbody>", camera))
    # From behind what reaches ahead is hidden, and the robot narrow.
    columns = [np.ptp(np.nonzero(robot_in(pixels))[1]) for pixels in (shown(arm()), behind)]
    assert columns[1] < 0.7 * columns[0]


def test_ground_is_darker_below_and_the_robot_lighter_above():
    ball = """<mujoco><worldbody><body pos="0 0 1.02"><geom type="sphere" size="1" rgba="0.9 0.1 0.1 1"/>
      </body></worldbody></mujoco>"""
    pixels = shown(ball).astype(int)
    robot = robot_in(pixels)
    rows, columns = np.nonzero(robot)
    red, above = pixels[rows, columns, 0], rows < (rows.min() + rows.max()) / 2
    assert red[above].mean() > red[~above].mean() + 15
    assert pixels[~robot].min() < 190


def test_robot_without_geometry_has_its_joints_and_links():
    xml = """<mujoco><worldbody>
      <body pos="0 0 0.5"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint/>
        <body pos="0.3 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint/>
          <body pos="0 0 0.3"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint/></body>
        </body>
      </body></worldbody></mujoco>"""
    pixels = shown(xml)
    orange = robot_in(pixels)
    assert 0.003 < orange.mean() < 0.1
    assert shown("<mujoco><worldbody/></mujoco>").shape == (SIZE[1], SIZE[0], 3)


def test_what_is_behind_clear_plastic_is_seen_through_it():
    xml = """<mujoco><worldbody><camera name="overview" pos="0 -4 0" xyaxes="1 0 0 0 0 1"/><body>
      <geom type="box" size="0.3 0.1 0.3" rgba="0.9 0.1 0.1 1"/>
      <geom type="box" size="0.6 0.02 0.6" pos="0 -0.3 0" rgba="0.1 0.1 0.9 {alpha}"/>
      </body></worldbody></mujoco>"""
    middle, aside = (SIZE[1] // 2, SIZE[0] // 2), (SIZE[1] // 2, SIZE[0] // 2 + 80)
    clear, solid = (shown(xml.format(alpha=alpha)).astype(int) for alpha in (0.3, 1))
    assert solid[middle][2] > 2 * solid[middle][0]
    assert clear[middle][0] > clear[middle][2]
    assert clear[aside][2] > clear[aside][0] + 30
    assert clear[aside].sum() > solid[aside].sum() + 100


def test_without_visual_geoms_the_colliders_are_seen():
    xml = arm().replace('contype="0" conaffinity="0"', "")
    assert robot_in(shown(xml)).mean() > 0.05


TILE = """v -1 0 0\nv 1 0 0\nv 1 0 1\nv -1 0 1\nv 0 1 0.5
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5
f 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 1/1 5/5 2/2\nf 2/2 5/5 3/3\nf 3/3 5/5 4/4\nf 4/4 5/5 1/1
"""
"""A mesh with a square towards -y, over which an image lies: the first row of the image is at vt = 1."""


def test_texture_is_laid_on_the_right_way_up():
    image = np.zeros((8, 8, 3), dtype=np.uint8)
    image[:4, :4], image[:4, 4:], image[4:, :4], image[4:, 4:] = RED, GREEN, BLUE, YELLOW
    xml = """<mujoco><asset><texture name="t" type="2d" file="t.png"/><material name="t" texture="t"/>
      <mesh name="t" file="t.obj"/></asset>
      <worldbody><camera name="overview" pos="0 -4 0.5" xyaxes="1 0 0 0 0 1"/>
      <body><geom type="mesh" mesh="t" material="t"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml, {"t.png": png.encode(image), "t.obj": TILE.encode()})
    pixels = draw_picture(scene_of(model), *SIZE).astype(int)
    rows, columns = np.nonzero(robot_in(pixels))
    places = [np.quantile(positions, [0.25, 0.75]).astype(int) for positions in (rows, columns)]
    colours = [pixels[row, column] > 120 for row in places[0] for column in places[1]]
    assert np.array_equal(colours, np.array([RED, GREEN, BLUE, YELLOW]) > 120)


def test_robot_of_many_triangles_is_thinned_and_looks_the_same(monkeypatch):
    ball = trimesh.creation.icosphere(4, 0.3)
    xml = """<mujoco><asset><mesh name="b" file="b.obj"/></asset><worldbody><body>
      <geom type="mesh" mesh="b" rgba="0.9 0.1 0.1 1"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml, {"b.obj": ball.export(file_type="obj").encode()})
    whole = scene_of(model)
    monkeypatch.setattr("linkwright.stages.show.preview.surface._MAX_TRIANGLES", 100)
    monkeypatch.setattr("linkwright.stages.show.preview.surface._CELLS", 16)
    thin = scene_of(model)
    assert len(thin.corners) < len(whole.corners) / 2
    pixels = [draw_picture(robot, *SIZE) for robot in (whole, thin)]
    first, second = (robot_in(pixel) for pixel in pixels)
    assert (first & second).sum() / (first | second).sum() > 0.95
    assert np.abs(np.median(pixels[0][first], axis=0) - np.median(pixels[1][second], axis=0)).max() < 12


def test_robot_that_turns_stays_in_the_picture_in_one_size():
    scene = scene_of(mujoco.MjModel.from_xml_string(arm()))
    framed, heights = swept_points(scene), []
    for angle in np.linspace(0, 2 * np.pi, 7, endpoint=False):
        other = turned_by(scene, angle)
        camera = framing(framed, other.backward, *SIZE)
        places = camera.projected(scene.corners)
        shares = places[..., :2] / SIZE
        assert ((shares > 0.04) & (shares < 0.96)).all()
        heights.append(np.linalg.norm(camera.position))
        # The key light stays where the camera is.
        assert other.key @ other.backward == pytest.approx(scene.key @ scene.backward)
        # To the left of the camera.
        assert other.key @ camera.world_from_camera[:, 0] < -0.05
    assert heights == pytest.approx([heights[0]] * len(heights), rel=0.01)


def models():
    yield pytest.param({"xml": arm()}, id="every shape")
    for name in ("so101", "duck"):
        scene = FILES[name][1].parent / "scene.xml"
        skip = pytest.mark.skipif(not is_here(name) or not scene.exists(), reason="the robot is not here")
        yield pytest.param({"path": str(scene)}, id=name, marks=[skip, pytest.mark.slow])


@pytest.mark.parametrize("model", list(models()))
def test_mujocos_own_renderer_sees_the_same_silhouette(model, tmp_path):
    by_path = "path" in model
    compiled = (mujoco.MjModel.from_xml_path if by_path else mujoco.MjModel.from_xml_string)(*model.values())
    scene = scene_of(compiled)
    camera = framing(scene.surface.corners.reshape(-1, 3), scene.backward, *SIZE)
    own = nearest_triangles(camera.projected(scene.surface.corners), *SIZE) >= 0
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, camera.world_from_camera.flatten())
    fovy = 2 * np.degrees(np.arctan(SIZE[1] / 2 / camera.focal))
    theirs = silhouette_by_driver(tmp_path, camera.position, quat, float(fovy), SIZE, **model)
    if theirs is None:
        pytest.skip("no graphics driver works here")
    assert 0.03 < own.mean() < 0.7
    assert (own & theirs).sum() / (own | theirs).sum() > 0.97
    # What is drawn is where the rasteriser sees it.
    drawn = render(scene, framing(scene.corners.reshape(-1, 3), scene.backward, 640, 480))
    changed = np.abs(drawn.astype(int) - drawn[0, 0].astype(int)).max(axis=2) > 60
    assert changed[own].mean() > 0.4
