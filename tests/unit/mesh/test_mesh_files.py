"""Mesh files: STL or OBJ that others read, pieces that MuJoCo compiles, names that never meet."""

import io
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.meshes.surface import Surface, round_to_single, transform_surface
from linkwright.stages.formats.xml import parse
from linkwright.stages.mesh.assets import convert_assets, surface
from linkwright.stages.mesh.files import mesh_file, obj, stl
from linkwright.stages.mesh.files.mesh_file import collider, visuals
from linkwright.stages.mesh.files.names import file_names, part_words
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from tests.support.building import plan_of, shaped, write
from tests.support.checked import checked
from tests.support.fidelity import mesh_of
from tests.support.kit import hinged, two_arms
from tests.support.pinocchio import pin

CUBE = convex_hull(np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float))
RED = (1.0, 0.0, 0.0, 1.0)


def square(size=1.0):
    corners = size * np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    return Surface(corners, np.array([[0, 1, 2], [0, 2, 3]]))


def reread(data):
    return trimesh.load(io.BytesIO(data), file_type="stl")


def compiles(data):
    """Whether MuJoCo takes the file as a visual of a URDF, which has no word for its inertia."""
    text = """<robot name="r"><mujoco><compiler strippath="false" fusestatic="false" discardvisual="false"/>
      </mujoco><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
      iyz="0"/></inertial><visual><geometry><mesh filename="m.stl"/></geometry></visual></link></robot>"""
    return mujoco.MjModel.from_xml_string(text, {"m.stl": data}).nmesh == 1


def test_file_is_read_back_with_its_volume_and_normals():
    data = stl.write(CUBE)
    assert (data[:10], len(data)) == (b"linkwright", 84 + 50 * 12)
    mesh = reread(data)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(1)
    stored = np.frombuffer(data[84:], dtype=np.uint8).reshape(12, 50)[:, :12].copy().view("<f4")
    assert np.allclose(stored, mesh.face_normals)
    shape = collider(transform_surface(CUBE, np.diag([0.1, 0.2, 0.3, 1])))
    mesh = reread(shape.data)
    assert (shape.faces, shape.vertices, shape.colour) == (12, 8, None)
    assert (shape.volume, shape.area) == pytest.approx((mesh.volume, mesh.area), rel=1e-6)


def test_mirroring_transform_keeps_the_outside_outside():
    mirror = np.diag([-2.0, 1, 1, 1])
    mirror[:3, 3] = [1, 2, 3]
    turned = transform_surface(CUBE, mirror)
    assert turned.volume() == transform_surface(CUBE, np.diag([2.0, 1, 1, 1])).volume() == pytest.approx(2)
    assert turned.vertices.min(axis=0) == pytest.approx([-1, 2, 3])


def test_triangles_smaller_than_single_precision_are_not_written():
    vertices = np.concatenate([CUBE.vertices + 1000, [[1000, 1000, 1000 + 1e-6]]])
    (part,) = visuals(Surface(vertices, np.concatenate([CUBE.triangles, [[0, 8, 7]]])), RED)
    assert (part.faces, part.vertices) == (12, 8)


@pytest.mark.parametrize("size", [1.0, 1e-2, 1e-4])
@pytest.mark.parametrize("place", [(0, 0, 0), (3, -2, 1)])
def test_flat_visual_gets_a_back_that_mujoco_accepts(size, place):
    pose = from_parts(rotation_from_rpy((0, 0.7, 0)), np.array(place, dtype=float))
    (part,) = visuals(transform_surface(square(size), pose), RED)
    assert part.faces == 4
    assert compiles(part.data)
    heights = ((reread(part.data).triangles.reshape(-1, 3) - place) @ pose[:3, :3])[:, 2]
    assert -max(1e-5, size) < heights.min() <= heights.max() < 1e-6
    assert part.area == pytest.approx(2 * size**2, rel=0.1)


def test_triangles_and_solids_are_written_and_specks_left_out():
    (triangle,) = visuals(Surface(square().vertices, np.array([[0, 1, 2]])), RED)
    assert compiles(triangle.data)
    assert not list(visuals(square(1e-5), RED))
    (part,) = visuals(CUBE, RED)
    assert (part.faces, part.volume, part.colour) == (12, pytest.approx(1), RED)


@pytest.mark.parametrize(("height", "sides"), [(1, 1), (0, 2)], ids=["wavy", "flat with a back"])
def test_no_file_has_more_faces_than_mujoco_reads(monkeypatch, height, sides):
    monkeypatch.setattr(mesh_file, "MAX_FACES", 100)
    x, y = np.meshgrid(np.arange(13.0), np.arange(13.0), indexing="ij")
    points = np.stack([x, y, height * np.sin(x)], axis=-1).reshape(-1, 3)
    corner = (np.arange(12)[:, None] * 13 + np.arange(12)).ravel()
    halves = np.stack([corner, corner + 13, corner + 14], 1), np.stack([corner, corner + 14, corner + 1], 1)
    parts = list(visuals(Surface(points, np.concatenate(halves)), RED))
    assert sum(part.faces for part in parts) == sides * 2 * 12 * 12
    assert max(part.faces for part in parts) <= 100


def test_file_names_follow_the_link_and_number_only_several():
    assert file_names({"base": (1, 1), "arm": (2, 2), "tip": (0, 0), "leaf": (1, 0), "fin": (0, 1)}) == {
        "base": (["base.stl"], ["base_collision.stl"]),
        "arm": (["arm_1.stl", "arm_2.stl"], ["arm_collision_1.stl", "arm_collision_2.stl"]),
        "tip": ([], []),
        "leaf": (["leaf.stl"], []),
        "fin": ([], ["fin_collision.stl"]),
    }
    many, _ = file_names({"arm": (12, 1)})["arm"]
    assert many == sorted(many)


def test_file_names_of_links_that_look_like_files_never_meet():
    links = {"arm": (2, 1), "ARM_1": (2, 1), "arm_1_1": (1, 1), "arm_collision": (1, 1)}
    names = [name for visuals, colliders in file_names(links).values() for name in [*visuals, *colliders]]
    assert len({name.casefold() for name in names}) == len(names) == 10
    assert names[:2] == ["arm__1.stl", "arm__2.stl"]


def lump(seed):
    rng = np.random.default_rng(seed)
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=0.05)
    points = mesh.vertices * (1 + 0.3 * rng.random((len(mesh.vertices), 1))) * 10.0 ** rng.integers(-4, 4)
    return round_to_single(Surface(points, np.asarray(mesh.faces).astype(np.int64)))


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
    path = str(tmp_path / "robot.urdf")
    for kind in (pin.VISUAL, pin.COLLISION):
        shapes = pin.buildGeomFromUrdf(pin.buildModelFromUrdf(path), path, kind, package_dirs=[str(tmp_path)])
        assert shapes.ngeoms == len(robot.links)
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


def test_meshes_of_other_colours_are_one_unless_textured():
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
    result, kept, _ = convert_assets(shapes, files, section)
    assert [shape.file for shape in result] == ["b.stl", "b.stl", "b.stl", "c.stl"]
    assert kept == {"b.stl": data, "c.stl": files["c.stl"]}
    assert [shape.colour for shape in result] == colours
    dressed = [replace(shape, texture="wood.png") for shape in shapes[1:3]]
    textured = {"b.stl": obj.write(lump(1)), "a.stl": obj.write(lump(1)), "wood.png": b"PNG"}
    result, kept, _ = convert_assets(
        [*dressed, replace(dressed[0], link="d", file="a.stl")], textured, section
    )
    assert [shape.file for shape in result] == ["b.obj", "a.obj", "b.obj"]
    assert sorted(kept) == ["a.mtl", "a.obj", "b.mtl", "b.obj", "wood.png"]
