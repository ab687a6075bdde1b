"""Mesh files as they are written: STL or OBJ, by colour or by part, or none at all."""

import io
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.meshes.surface import Surface, rounded
from linkwright.stages.formats.xml import parse
from linkwright.stages.mesh.assets import converted, surface
from linkwright.stages.mesh.files import obj, stl
from linkwright.stages.mesh.files.names import file_names, part_words
from linkwright.stages.robot.model.geometry import Shape
from tests.support.building import plan_of, shaped, write
from tests.support.checked import checked
from tests.support.fidelity import mesh_of
from tests.support.kit import hinged, two_arms
from tests.support.pinocchio import pin


def lump(seed):
    rng = np.random.default_rng(seed)
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=0.05)
    points = mesh.vertices * (1 + 0.3 * rng.random((len(mesh.vertices), 1))) * 10.0 ** rng.integers(-4, 4)
    return rounded(Surface(points, np.asarray(mesh.faces).astype(np.int64)))


@pytest.mark.parametrize("seed", range(4))
def test_obj_has_exactly_the_points_of_the_stl(seed):
    original = lump(seed)
    data = obj.write(surface(stl.write(original)))
    by_obj = trimesh.load(io.BytesIO(data), file_type="obj", process=False)
    by_stl = trimesh.load(io.BytesIO(stl.write(original)), file_type="stl")
    assert np.array_equal(by_obj.triangles.astype(np.float32), by_stl.triangles.astype(np.float32))
    assert by_obj.is_watertight
    assert len(by_obj.vertices) == len(original.vertices)
    assert obj.write(surface(stl.write(original))) == data
    assert {line[:2] for line in data.decode().splitlines()} == {"v ", "f "}


def test_numbers_are_short():
    points = np.array([[0.1, -0.0, 1.0], [1e-7, 20.0, 0.3], [0.5, 0.25, 123456.0]])
    data = obj.write(Surface(points, np.array([[0, 1, 2]])))
    assert data == b"v 0.1 0 1\nv 1e-07 20 0.3\nv 0.5 0.25 123456\nf 1 2 3\n"


def test_every_reader_takes_the_obj_files(kit, tmp_path):
    hinged(kit)
    robot, geometry, plan = shaped(kit.document, mesh={"format": "obj"})
    assert {Path(name).suffix for name in geometry.files} == {".obj"}
    assert sorted(geometry.files) == sorted(shape.file for shape in geometry.shapes if shape.file)
    write(robot, tmp_path, plan, geometry)
    urdf = str(tmp_path / "robot.urdf")
    models = [mujoco.MjModel.from_xml_path(path) for path in (str(tmp_path / "robot.xml"), urdf)]
    assert [model.nmesh for model in models] == [len(geometry.files)] * 2
    for kind in (pin.VISUAL, pin.COLLISION):
        shapes = pin.buildGeomFromUrdf(pin.buildModelFromUrdf(urdf), urdf, kind, package_dirs=[str(tmp_path)])
        assert shapes.ngeoms == 2
    assert [check for check in checked(tmp_path, robot, plan) if check.fails] == []


def test_without_assets_masses_and_primitives_stay(kit, tmp_path):
    hinged(kit)
    robot, geometry, plan = shaped(kit.document, mesh={"assets": "none"})
    assert (geometry.files, geometry.shapes) == ({}, ())
    assert [(row.code, row.where) for row in geometry.diagnostics] == [
        ("I-NO-ASSETS", "mesh.assets"),
        ("W-NO-COLLIDER", "mesh.assets"),
    ]
    assert geometry.diagnostics[0].message.startswith("2 visual meshes and 2 colliders")
    write(robot, tmp_path, plan, geometry)
    assert not (tmp_path / "assets").exists()
    for name in ("robot.urdf", "robot.xml"):
        assert parse((tmp_path / name).read_bytes()).findall(".//mesh") == []
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert model.body_mass.sum() == pytest.approx(sum(link.inertial.mass for link in robot.links))
    assert [check for check in checked(tmp_path, robot, plan) if check.fails] == []


def test_by_part_each_part_has_its_mesh_and_its_name(kit):
    hinged(kit)
    robot, geometry, _ = shaped(kit.document, mesh={"visual": {"merge": "part"}})
    seen = [shape for shape in geometry.shapes if shape.role == "visual"]
    assert len({(shape.link, shape.file) for shape in seen}) == len(seen)
    assert [shape.link for shape in seen] == [link.name for link in robot.links for _ in link.parts]
    assert all(shape.faces > 0 for shape in seen)


def test_names_of_parts_are_stable_and_unique():
    assert part_words(["Arm/Screw <1>", "Arm/Screw <2>", "Arm/Plate <1>"]) == ["screw", "screw_2", "plate"]
    assert part_words(["A/Pin <1>", "B/Pin <1>", "Plate <1>"]) == ["a_pin", "b_pin", "plate"]
    words = ["plate__1", "plate__2", "part_collision"]
    assert part_words(["Plate <1>", "Plate <1>", "Collision <1>"]) == words
    assert file_names({"arm": (["screw", "plate__1"], 2), "base": (1, 1)}) == {
        "arm": (
            ["arm_screw.stl", "arm_plate__1.stl"],
            ["arm_collision_1.stl", "arm_collision_2.stl"],
        ),
        "base": (["base.stl"], ["base_collision.stl"]),
    }


@pytest.mark.parametrize("form", ["stl", "obj"])
def test_meshes_of_the_same_content_are_one_file(kit, tmp_path, form):
    two_arms(kit)
    robot, geometry, plan = shaped(kit.document, mesh={"format": form})
    assert len(set(geometry.files.values())) == len(geometry.files)
    names = {shape.link: shape.file for shape in geometry.shapes if shape.role == "visual"}
    assert names["right"] == names["left"] == f"left.{form}"
    write(robot, tmp_path, plan, geometry)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert model.nmesh == len(geometry.files)
    urdf = parse((tmp_path / "robot.urdf").read_bytes())
    assert {f"assets/{name}" for name in geometry.files} == set(urdf.xpath("//mesh/@filename"))
    assert [check for check in checked(tmp_path, robot, plan) if check.fails] == []
    # The corners of each link's bar, in the frame of its body, in closed form.
    half = np.array([0.02, 0.03, 0.1]) / 2
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    for link in robot.links:
        (part,) = link.parts
        corners = part.inertial.com + signs * half
        expected = corners @ part.link_from_part[:3, :3].T + part.link_from_part[:3, 3]
        body = model.body(link.name)
        for geom in range(int(body.geomadr[0]), int(body.geomadr[0] + body.geomnum[0])):
            far = np.abs(mesh_of(model, geom).vertices[:, None] - expected[None]).max(axis=2)
            assert max(far.min(axis=1).max(), far.min(axis=0).max()) < 1e-6


def test_meshes_that_differ_in_colour_only_are_one_but_for_a_texture():
    data = stl.write(lump(1))
    names = ["b_collision.stl", "b.stl", "a.stl", "c.stl"]
    colours = [None, (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0), None]
    roles = ["collision", "visual", "visual", "visual"]
    shapes = [
        Shape(name[0], role, name, colour, 3, 1, 1.0, 1.0)
        for name, colour, role in zip(names, colours, roles, strict=True)
    ]
    files = dict.fromkeys(names[:3], data) | {"c.stl": stl.write(lump(2))}
    section = plan_of().mesh
    (result, kept), _ = converted(shapes, files, section)
    assert [shape.file for shape in result] == ["b.stl", "b.stl", "b.stl", "c.stl"]
    assert kept == {"b.stl": data, "c.stl": files["c.stl"]}
    assert [shape.colour for shape in result] == colours
    dressed = [replace(shape, texture="wood.png") for shape in shapes[1:3]]
    textured = {"b.stl": obj.write(lump(1)), "a.stl": obj.write(lump(1)), "wood.png": b"PNG"}
    (result, kept), _ = converted([*dressed, replace(dressed[0], link="d", file="a.stl")], textured, section)
    assert [shape.file for shape in result] == ["b.obj", "a.obj", "b.obj"]
    assert sorted(kept) == ["a.mtl", "a.obj", "b.mtl", "b.obj", "wood.png"]
