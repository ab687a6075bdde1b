"""Textures of an MJCF: what MuJoCo compiles is what our files have."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats import png
from tests.support.mjcfs import at_home, written
from tests.support.textures import (
    QUADRANTS,
    Corners,
    built,
    by_mujoco,
    by_trimesh,
    cube,
    exported,
    image,
    obj,
    ordered,
    put,
)
from tests.support.textures import png as by_hand

ASSETS = """<asset><texture name="four" type="2d" file="four.png"/>
<material name="painted" texture="four" rgba=".5 .75 1 1"/><mesh name="cube" file="cube.obj"{}/></asset>"""
GEOM = '<geom type="mesh" mesh="cube" {}/>'
SEEN = 'material="painted" contype="0" conaffinity="0"'


@pytest.fixture(autouse=True)
def _guests_at_home(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("linkwright.stages.robot.system.guest.ask", at_home)


def source(
    folder: Path, *geoms: str, assets: str = ASSETS.format(""), body: str = "", picture: bytes | None = None
) -> dict[str, str]:
    put(folder, **{"four.png": picture or image(), "cube.obj": obj(cube())})
    inside = "".join(geoms or [GEOM.format(SEEN)])
    text = f'<mujoco model="m">{assets}<worldbody><body name="a" {body}>{inside}</body></worldbody></mujoco>'
    return {"kind": "mjcf", "path": str(written(folder, text))}


def lost(given: dict[str, str]) -> str:
    robot, _, _, fetched = built(given)
    return " ".join(
        one.message for one in (*fetched.diagnostics, *robot.diagnostics) if "MJCF-LEFT" in one.code
    )


def placed(given: dict[str, str]) -> Corners:
    """The corners of the first geom's mesh in its body, as MuJoCo has them in the original."""
    model = mujoco.MjModel.from_xml_path(given["path"])
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[0])
    # MuJoCo moved the geom with the mesh, which `by_mujoco` moves back.
    back = np.zeros(9)
    mujoco.mju_quat2Mat(back, model.mesh_quat[0])
    found = by_mujoco(model, 0)
    local = (found[..., :3] - model.mesh_pos[0]) @ back.reshape(3, 3)
    found[..., :3] = local @ turn.reshape(3, 3).T + model.geom_pos[0]
    return found


def test_a_texture_survives_with_its_coordinates_pixels_and_colour(tmp_path: Path) -> None:
    given = source(tmp_path / "source")
    robot, geometry, _ = exported(tmp_path, given)
    (shape,) = geometry.of("a", "visual")
    assert shape.colour == (0.5, 0.75, 1.0, 1.0)
    assert np.allclose(ordered(by_trimesh(tmp_path / "assets" / "a.obj")), ordered(cube()), atol=2e-6)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert np.allclose(ordered(by_mujoco(model, 0)), ordered(cube()), atol=2e-6)
    original = mujoco.MjModel.from_xml_path(given["path"])
    assert model.ntex == original.ntex == 1
    assert np.array_equal(model.tex_data, original.tex_data)
    assert (tmp_path / "robot.urdf").read_text().count("<texture ") == 1
    assert "texture" not in lost(given)
    assert robot.name == "robot"


@pytest.mark.parametrize("scale", ["1 -2 1", "-1 -1 -1", "2 2 2"])
def test_scaled_and_mirrored_meshes_are_as_mujoco_has_them(tmp_path: Path, scale: str) -> None:
    given = source(
        tmp_path / "source",
        GEOM.format(f'{SEEN} pos="0 0 1" euler="30 0 40"'),
        assets=ASSETS.format(f' scale="{scale}"'),
    )
    exported(tmp_path, given)
    found = by_trimesh(tmp_path / "assets" / "a.obj")
    assert np.allclose(ordered(np.round(found, 4)), ordered(np.round(placed(given), 4)), atol=2e-4)


def test_coordinates_in_the_file_and_a_texture_that_mujoco_makes(tmp_path: Path) -> None:
    corners = "0 0 0 1 0 0 0 1 0 0 0 1"
    assets = f"""<asset><mesh name="cube" vertex="{corners}" texcoord="0 0 1 0 0 1 1 1"/>
    <texture name="check" type="2d" builtin="checker" width="8" height="8" rgb1="1 0 0" rgb2="0 1 0"/>
    <material name="painted" texture="check"/></asset>"""
    given = source(tmp_path / "source", assets=assets)
    exported(tmp_path, given)
    assert np.allclose(ordered(by_trimesh(tmp_path / "assets" / "a.obj")), ordered(placed(given)), atol=1e-6)
    made, original = (
        mujoco.MjModel.from_xml_path(path) for path in (str(tmp_path / "robot.xml"), given["path"])
    )
    assert np.array_equal(made.tex_data, original.tex_data)


def test_a_geoms_own_colour_is_times_the_image(tmp_path: Path) -> None:
    given = source(tmp_path, GEOM.format(f'{SEEN} rgba="1 0 0 1"'), GEOM.format(SEEN))
    _, geometry, _, _ = built(given)
    shapes = geometry.of("a", "visual")
    assert {shape.colour for shape in shapes} == {(1.0, 0.0, 0.0, 1.0), (0.5, 0.75, 1.0, 1.0)}
    assert len({shape.texture for shape in shapes}) == 1


@pytest.mark.parametrize(
    ("geom", "assets"),
    [
        ('<geom size=".1 .1 .1" type="box" material="painted" contype="0" conaffinity="0" mass="1"/>', ""),
        ("", '<texture name="four" type="cube" builtin="flat" width="4" height="4"/>'),
        ("", '<mesh name="cube" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>'),
    ],
)
def test_a_texture_without_coordinates_is_named(tmp_path: Path, geom: str, assets: str) -> None:
    whole = ASSETS.format("")
    for kind in ("texture", "mesh"):
        if assets.startswith(f"<{kind}"):
            start = whole.index(f"<{kind}")
            whole = whole[:start] + assets + whole[whole.index("/>", start) + 2 :]
    given = source(tmp_path, *([geom] if geom else []), assets=whole)
    _, geometry, _, _ = built(given)
    assert [shape.texture for shape in geometry.of("a", "visual") if shape.file] in ([], [None])
    assert "1 × material texture (painted)" in lost(given)
    assert "1 × texture (four)" in lost(given)


def test_a_texture_that_is_lost_on_one_geom_only_is_named_with_its_material(tmp_path: Path) -> None:
    box = '<geom size=".1 .1 .1" type="box" material="painted" contype="0" conaffinity="0" mass="1"/>'
    text = lost(source(tmp_path, box, GEOM.format(SEEN)))
    assert "material texture (painted)" in text
    assert "texture (four)" not in text


def test_a_collider_that_is_not_seen_needs_no_texture(tmp_path: Path) -> None:
    given = source(tmp_path, GEOM.format('material="painted" group="3"'), GEOM.format(SEEN))
    _, geometry, _, fetched = built(given)
    assert len(geometry.of("a", "visual")) == 1
    assert len([request for request in fetched.bundle.requests if request.startswith("mesh/")]) == 2


@pytest.mark.parametrize("colour", [0, 2, 6])
def test_images_of_any_kind_are_the_pixels_that_mujoco_has(tmp_path: Path, colour: int) -> None:
    channels = {0: 1, 2: 3, 6: 4}[colour]
    pixels = np.random.default_rng(colour).integers(0, 256, (6, 4, channels), dtype=np.uint8)
    picture = by_hand(4, 6, [row.tobytes() for row in pixels], colour=colour)
    given = source(tmp_path / "source", picture=picture)
    exported(tmp_path, given)
    made, original = (
        mujoco.MjModel.from_xml_path(path) for path in (str(tmp_path / "robot.xml"), given["path"])
    )
    assert np.array_equal(made.tex_data, original.tex_data)
    assert made.tex_nchannel[0] == 3


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_a_png_of_ours_has_its_pixels(channels: int) -> None:
    pixels = np.random.default_rng(channels).integers(0, 256, (5, 7, channels), dtype=np.uint8)
    data = png.encode(pixels)
    assert png.problem(data) == ""
    texture = f'<texture name="t" type="2d" file="t.png" nchannel="{channels}"/>'
    text = f"<mujoco><asset>{texture}</asset></mujoco>"
    model = mujoco.MjModel.from_xml_string(text, assets={"t.png": data})
    assert np.array_equal(model.tex_data.reshape(pixels.shape), pixels)


def test_the_quadrants_are_where_they_were(tmp_path: Path) -> None:
    given = source(tmp_path / "source")
    exported(tmp_path, given)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    pixels = model.tex_data.reshape(4, 4, 3)
    assert [tuple(pixels[row, column]) for row in (0, 3) for column in (0, 3)] == list(QUADRANTS)
