"""Textures from a URDF to the files: every corner keeps its place in the image."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats.xml import parse
from tests.support.checked import checked
from tests.support.textures import (
    QUADRANTS,
    by_mujoco,
    by_trimesh,
    cube,
    exported,
    image,
    obj,
    ordered,
    put,
    urdf,
    visual,
)

MTL = b"newmtl m\nKd 0.5 0.75 1\nmap_Kd four.png\n"


def robot(folder: Path, *visuals: str, **files: bytes) -> dict[str, str]:
    """The source: a robot with these visuals, of the textured cube unless said otherwise."""
    folder = folder / "source"
    put(folder, **{"robot.urdf": urdf(*(visuals or [visual("cube.obj")]))})
    put(folder, **{"cube.obj": obj(cube()), "m.mtl": MTL, "four.png": image(), **files})
    return {"kind": "urdf", "path": str(folder / "robot.urdf")}


def models(folder: Path) -> list[mujoco.MjModel]:
    spec = mujoco.MjSpec.from_string((folder / "robot.urdf").read_text())
    spec.modelfiledir = str(folder)
    return [mujoco.MjModel.from_xml_path(str(folder / "scene.xml")), spec.compile()]


def test_every_corner_has_its_place_in_the_image_in_the_obj_and_in_mujoco(tmp_path: Path) -> None:
    built, geometry, plan = exported(tmp_path, robot(tmp_path))
    (shape,) = geometry.of("a", "visual")
    assert (shape.file, shape.colour) == ("a.obj", (0.501961, 0.74902, 1.0, 1.0))
    assert sorted(geometry.files) == ["a.mtl", "a.obj", shape.texture]
    assert geometry.files[shape.texture or ""] == image()
    wanted = ordered(cube())
    assert np.allclose(ordered(by_trimesh(tmp_path / "assets" / "a.obj")), wanted)
    for model in models(tmp_path):
        assert np.allclose(ordered(by_mujoco(model, model.mesh("a").id)), wanted, atol=2e-6)
    assert [check for check in checked(tmp_path, built, plan) if check.fails] == []


def test_the_mjcf_paints_the_geom_with_the_image_and_the_colour(tmp_path: Path) -> None:
    _, geometry, _ = exported(tmp_path, robot(tmp_path))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert model.ntex == 1
    assert model.tex_type[0] == mujoco.mjtTexture.mjTEXTURE_2D
    (material,) = {int(one) for one in model.geom_matid if one >= 0}
    assert model.mat_texid[material][mujoco.mjtTextureRole.mjTEXROLE_RGB] == 0
    assert model.mat_rgba[material] == pytest.approx(geometry.of("a", "visual")[0].colour)
    pixels = model.tex_data.reshape(4, 4, 3)
    assert [tuple(pixels[row, column]) for row in (0, 3) for column in (0, 3)] == list(QUADRANTS)


def test_the_urdf_names_the_image_and_so_does_the_library_of_the_obj(tmp_path: Path) -> None:
    _, geometry, _ = exported(tmp_path, robot(tmp_path))
    texture = geometry.of("a", "visual")[0].texture
    root = parse((tmp_path / "robot.urdf").read_bytes())
    name = root.find("link/visual/material").get("name")
    assert root.find(f"material[@name='{name}']/texture").get("filename") == f"assets/{texture}"
    library = (tmp_path / "assets" / "a.mtl").read_text()
    assert f"map_Kd {texture}\n" in library
    assert "Kd 0.501961 0.74902 1\n" in library
    lines = (tmp_path / "assets" / "a.obj").read_text().splitlines()
    assert lines[0] == "mtllib a.mtl"
    assert library.startswith(f"newmtl {lines[1].removeprefix('usemtl ')}\n")


@pytest.mark.parametrize("scale", ["1 -2 1", "-1 -1 -1", "1 2 -0.5", "-1 1 -1"])
def test_mirrored_and_scaled_meshes_keep_their_coordinates(tmp_path: Path, scale: str) -> None:
    exported(tmp_path, robot(tmp_path, visual("cube.obj", scale=scale, xyz="0.1 0.2 0.3")))
    wanted = cube()
    wanted[..., :3] = wanted[..., :3] * np.array([float(one) for one in scale.split()]) + [0.1, 0.2, 0.3]
    if np.prod([float(one) for one in scale.split()]) < 0:
        wanted = wanted[:, ::-1]
    assert np.allclose(ordered(by_trimesh(tmp_path / "assets" / "a.obj")), ordered(wanted), atol=2e-6)


def test_an_image_is_one_file_and_a_mesh_has_one_image_and_colour(tmp_path: Path) -> None:
    other = image(colours=QUADRANTS[::-1])
    second = cube(shift=(0, 0, 0))
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
    _, geometry, _ = exported(tmp_path, source)
    shapes = geometry.of("a", "visual")
    assert sorted((shape.faces, shape.texture is None) for shape in shapes) == [
        (12, False),
        (12, True),
        (24, False),
    ]
    assert len({shape.colour for shape in shapes}) == 1
    assert {data for name, data in geometry.files.items() if name.endswith(".png")} == {image(), other}
    (mesh,) = [shape for shape in shapes if shape.texture and geometry.files[shape.texture] == other]
    found = by_trimesh(tmp_path / "assets" / (mesh.file or ""))
    assert np.allclose(ordered(found), ordered(second))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert (model.ntex, model.nmat) == (2, 3)
    assert [name for name in geometry.files if name.endswith(".stl")] == ["a_1.stl"]


def test_a_texture_may_be_on_some_faces_only(tmp_path: Path) -> None:
    lines = obj(cube(), library="two.mtl").decode().splitlines()
    lines.insert(-3, "usemtl plain")
    mtl = MTL + b"newmtl plain\nKd 1 0 0\n"
    source = robot(tmp_path, visual("two.obj"), **{"two.obj": "\n".join(lines).encode(), "two.mtl": mtl})
    _, geometry, _ = exported(tmp_path, source)
    assert {(shape.file, shape.faces, shape.texture is None) for shape in geometry.of("a", "visual")} == {
        ("a_1.obj", 9, False),
        ("a_2.stl", 3, True),
    }
    assert np.allclose(ordered(by_trimesh(tmp_path / "assets" / "a_1.obj")), ordered(cube()[:9]))


def test_a_flat_face_has_its_image_on_both_sides(tmp_path: Path) -> None:
    plane = cube()[[0, 6]]
    source = robot(tmp_path, visual("flat.obj"), **{"flat.obj": obj(plane)})
    exported(tmp_path, source)
    found = by_trimesh(tmp_path / "assets" / "a.obj")
    behind = plane[:, ::-1]
    assert np.allclose(ordered(found[:2]), ordered(plane), atol=2e-6)
    assert np.allclose(ordered(found[2:]), ordered(behind), atol=2e-6)


def test_a_textured_mesh_is_an_obj_in_either_format_and_none_without_assets(tmp_path: Path) -> None:
    source = robot(tmp_path)
    by_format = [exported(tmp_path / kind, source, format=kind)[1] for kind in ("stl", "obj")]
    assert by_format[0].files == by_format[1].files
    assert by_format[0].shapes == by_format[1].shapes
    _, nothing, _ = exported(tmp_path / "none", source, assets="none")
    assert (nothing.files, nothing.shapes) == ({}, ())
    assert "texture" not in (tmp_path / "none" / "robot.xml").read_text()


def test_parts_have_their_own_meshes_and_share_the_image(tmp_path: Path) -> None:
    source = robot(tmp_path, visual("cube.obj"), visual("cube.obj", xyz="1 0 0"))
    _, geometry, _ = exported(tmp_path, source, visual={"merge": "part"})
    assert [shape.faces for shape in geometry.of("a", "visual")] == [12, 12]
    assert {Path(name).suffix for name in geometry.files} == {".obj", ".mtl", ".png"}
    assert len([name for name in geometry.files if name.endswith(".png")]) == 1


def test_a_textured_part_keeps_its_triangles_and_a_warning_says_so(tmp_path: Path) -> None:
    _, geometry, _ = exported(tmp_path, robot(tmp_path), visual={"max_faces": 10})
    assert [shape.faces for shape in geometry.of("a", "visual")] == [12]
    (warning,) = [one for one in geometry.diagnostics if one.code == "W-VISUAL-FACES"]
    assert "texture" in warning.message


def test_the_files_are_a_source_that_gives_the_same_files(tmp_path: Path) -> None:
    _, first, _ = exported(tmp_path / "first", robot(tmp_path))
    again = {"kind": "urdf", "path": str(tmp_path / "first" / "robot.urdf")}
    _, second, _ = exported(tmp_path / "second", again)
    assert first.files == second.files
    assert first.shapes == second.shapes


def test_the_order_of_triangles_and_points_does_not_matter(tmp_path: Path) -> None:
    files = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        mixed = np.array([np.roll(one, rng.integers(3), axis=0) for one in rng.permutation(cube())])
        files.append(exported(tmp_path / str(seed), robot(tmp_path, **{"cube.obj": obj(mixed)}))[1].files)
    assert files[0] == files[1] == files[2]


def test_large_meshes_are_several_files_with_one_image(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("linkwright.stages.mesh.files.mesh_file.MOST_FACES", 7)
    _, geometry, _ = exported(tmp_path, robot(tmp_path))
    shapes = geometry.of("a", "visual")
    assert [shape.faces for shape in shapes] == [6, 6]
    assert len({shape.texture for shape in shapes}) == 1
    halves = [by_trimesh(tmp_path / "assets" / (shape.file or "")) for shape in shapes]
    assert np.allclose(ordered(np.concatenate(halves)), ordered(cube()))
