"""Textures from a URDF to the files: every corner keeps its place in the image."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats.xml import parse
from tests.support.checked import checked
from tests.support.textures import (
    QUADRANTS,
    built_into,
    by_mujoco,
    by_trimesh,
    cube,
    image,
    obj,
    ordered,
    put,
    urdf,
    visual,
)

MTL = b"newmtl m\nKd 0.5 0.75 1\nmap_Kd four.png\n"


def robot(folder, *visuals, **files):
    """The source: a robot with these visuals, of the textured cube unless said otherwise."""
    folder = folder / "source"
    put(folder, **{"robot.urdf": urdf(*(visuals or [visual("cube.obj")]))})
    put(folder, **{"cube.obj": obj(cube()), "m.mtl": MTL, "four.png": image(), **files})
    return {"kind": "urdf", "path": str(folder / "robot.urdf")}


def corners(folder, name="a.obj"):
    return ordered(by_trimesh(folder / "assets" / name))


def test_every_corner_has_its_place_in_the_image_in_every_file(tmp_path):
    built, geometry, plan = built_into(tmp_path, robot(tmp_path))
    (shape,) = geometry.shapes_of("a", "visual")
    assert (shape.file, shape.colour) == ("a.obj", (0.501961, 0.74902, 1.0, 1.0))
    assert sorted(geometry.files) == ["a.mtl", "a.obj", shape.texture]
    assert geometry.files[shape.texture] == image()
    assert np.allclose(corners(tmp_path), ordered(cube()))
    spec = mujoco.MjSpec.from_string((tmp_path / "robot.urdf").read_text())
    spec.modelfiledir = str(tmp_path)
    for model in (mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml")), spec.compile()):
        assert np.allclose(ordered(by_mujoco(model, model.mesh("a").id)), ordered(cube()), atol=2e-6)
    assert [check for check in checked(tmp_path, built, plan) if check.fails] == []
    # The MJCF paints the geom with the image and the colour.
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert (model.ntex, model.tex_type[0]) == (1, mujoco.mjtTexture.mjTEXTURE_2D)
    (material,) = {int(number) for number in model.geom_matid if number >= 0}
    assert model.mat_texid[material][mujoco.mjtTextureRole.mjTEXROLE_RGB] == 0
    assert model.mat_rgba[material] == pytest.approx(shape.colour)
    pixels = model.tex_data.reshape(4, 4, 3)
    assert [tuple(pixels[row, column]) for row in (0, 3) for column in (0, 3)] == list(QUADRANTS)
    # The URDF and the library of the OBJ name the image.
    root = parse((tmp_path / "robot.urdf").read_bytes())
    name = root.find("link/visual/material").get("name")
    assert root.find(f"material[@name='{name}']/texture").get("filename") == f"assets/{shape.texture}"
    library = (tmp_path / "assets" / "a.mtl").read_text()
    assert f"map_Kd {shape.texture}\n" in library
    assert "Kd 0.501961 0.74902 1\n" in library
    lines = (tmp_path / "assets" / "a.obj").read_text().splitlines()
    assert lines[0] == "mtllib a.mtl"
    assert library.startswith(f"newmtl {lines[1].removeprefix('usemtl ')}\n")
    # The files are a source that gives the same files.
    again = {"kind": "urdf", "path": str(tmp_path / "robot.urdf")}
    _, second, _ = built_into(tmp_path / "second", again)
    assert (second.files, second.shapes) == (geometry.files, geometry.shapes)


@pytest.mark.parametrize("scale", ["1 -2 1", "-1 -1 -1", "1 2 -0.5", "-1 1 -1"])
def test_mirrored_and_scaled_meshes_keep_their_coordinates(tmp_path, scale):
    built_into(tmp_path, robot(tmp_path, visual("cube.obj", scale=scale, xyz="0.1 0.2 0.3")))
    factors = np.array([float(word) for word in scale.split()])
    expected = cube()
    expected[..., :3] = expected[..., :3] * factors + [0.1, 0.2, 0.3]
    expected = expected[:, ::-1] if np.prod(factors) < 0 else expected
    assert np.allclose(corners(tmp_path), ordered(expected), atol=2e-6)


def test_image_is_one_file_and_a_mesh_has_one_image_and_colour(tmp_path):
    other, second = image(colours=QUADRANTS[::-1]), cube(shift=(0, 0, 0))
    source = robot(
        tmp_path,
        *(visual(f"{name}.obj") for name in ("cube", "same", "other", "plain")),
        **{
            "same.obj": obj(cube(shift=(-0.3, 0, 0)), library="same.mtl"),
            "same.mtl": MTL.replace(b"four", b"copy"),
            "copy.png": image(),
            "other.obj": obj(second, library="other.mtl"),
            "other.mtl": MTL.replace(b"four", b"other"),
            "other.png": other,
            "plain.obj": obj(cube(shift=(0, 1, 0)), library="plain.mtl"),
            "plain.mtl": b"newmtl m\nKd 0.5 0.75 1\n",
        },
    )
    _, geometry, _ = built_into(tmp_path, source)
    shapes = geometry.shapes_of("a", "visual")
    faces = sorted((shape.faces, shape.texture is None) for shape in shapes)
    assert faces == [(12, False), (12, True), (24, False)]
    assert len({shape.colour for shape in shapes}) == 1
    assert {data for name, data in geometry.files.items() if name.endswith(".png")} == {image(), other}
    (mesh,) = [shape for shape in shapes if shape.texture and geometry.files[shape.texture] == other]
    assert np.allclose(corners(tmp_path, mesh.file), ordered(second))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert (model.ntex, model.nmat) == (2, 3)
    assert [name for name in geometry.files if name.endswith(".stl")] == ["a_1.stl"]


def test_texture_may_be_on_some_faces_only(tmp_path):
    lines = obj(cube(), library="two.mtl").decode().splitlines()
    lines.insert(-3, "usemtl plain")
    mtl = MTL + b"newmtl plain\nKd 1 0 0\n"
    source = robot(tmp_path, visual("two.obj"), **{"two.obj": "\n".join(lines).encode(), "two.mtl": mtl})
    _, geometry, _ = built_into(tmp_path, source)
    shapes = {(shape.file, shape.faces, shape.texture is None) for shape in geometry.shapes_of("a", "visual")}
    assert shapes == {("a_1.obj", 9, False), ("a_2.stl", 3, True)}
    assert np.allclose(corners(tmp_path, "a_1.obj"), ordered(cube()[:9]))


def test_flat_face_has_its_image_on_both_sides(tmp_path):
    plane = cube()[[0, 6]]
    built_into(tmp_path, robot(tmp_path, visual("flat.obj"), **{"flat.obj": obj(plane)}))
    points = by_trimesh(tmp_path / "assets" / "a.obj")
    assert np.allclose(ordered(points[:2]), ordered(plane), atol=2e-6)
    assert np.allclose(ordered(points[2:]), ordered(plane[:, ::-1]), atol=2e-6)


def test_textured_mesh_is_an_obj_and_absent_without_assets(tmp_path):
    source = robot(tmp_path)
    stl, as_obj = (built_into(tmp_path / kind, source, format=kind)[1] for kind in ("stl", "obj"))
    assert (stl.files, stl.shapes) == (as_obj.files, as_obj.shapes)
    _, nothing, _ = built_into(tmp_path / "none", source, assets="none")
    assert (nothing.files, nothing.shapes) == ({}, ())
    assert "texture" not in (tmp_path / "none" / "robot.xml").read_text()


def test_parts_have_their_own_meshes_and_share_the_image(tmp_path):
    source = robot(tmp_path, visual("cube.obj"), visual("cube.obj", xyz="1 0 0"))
    _, geometry, _ = built_into(tmp_path, source, visual={"merge": "part"})
    assert [shape.faces for shape in geometry.shapes_of("a", "visual")] == [12, 12]
    assert {Path(name).suffix for name in geometry.files} == {".obj", ".mtl", ".png"}
    assert len([name for name in geometry.files if name.endswith(".png")]) == 1


def test_textured_part_keeps_its_triangles_and_a_warning_says_so(tmp_path):
    _, geometry, _ = built_into(tmp_path, robot(tmp_path), visual={"max_faces": 10})
    assert [shape.faces for shape in geometry.shapes_of("a", "visual")] == [12]
    (warning,) = [diagnostic for diagnostic in geometry.diagnostics if diagnostic.code == "W-VISUAL-FACES"]
    assert "texture" in warning.message


def test_order_of_triangles_and_points_does_not_matter(tmp_path):
    files = []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        mixed = np.array([np.roll(triangle, rng.integers(3), axis=0) for triangle in rng.permutation(cube())])
        files.append(built_into(tmp_path / str(seed), robot(tmp_path, **{"cube.obj": obj(mixed)}))[1].files)
    assert files[0] == files[1]


def test_large_meshes_are_several_files_with_one_image(tmp_path, monkeypatch):
    monkeypatch.setattr("linkwright.stages.mesh.files.mesh_file.MAX_FACES", 7)
    _, geometry, _ = built_into(tmp_path, robot(tmp_path))
    shapes = geometry.shapes_of("a", "visual")
    assert [shape.faces for shape in shapes] == [6, 6]
    assert len({shape.texture for shape in shapes}) == 1
    halves = [by_trimesh(tmp_path / "assets" / shape.file) for shape in shapes]
    assert np.allclose(ordered(np.concatenate(halves)), ordered(cube()))
