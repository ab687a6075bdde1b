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
from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.assets import surface, written
from linkwright.stages.mesh.files import obj, stl
from linkwright.stages.mesh.files.names import file_names, part_words
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Robot
from tests.support.building import bundle_of, plan_of, robot_of, write
from tests.support.checked import checked
from tests.support.kit import SIDE, TOP, Kit
from tests.support.pinocchio import pin


def built(kit: Kit, **mesh: object) -> tuple[Robot, Geometry, object]:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=(-1, 1))
    robot, plan = robot_of(kit.document), plan_of(mesh=mesh)
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    return robot, geometry, plan


def lump(seed: int) -> Surface:
    rng = np.random.default_rng(seed)
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=0.05)
    points = mesh.vertices * (1 + 0.3 * rng.random((len(mesh.vertices), 1))) * 10.0 ** rng.integers(-4, 4)
    return rounded(Surface(points, np.asarray(mesh.faces).astype(np.int64)))


@pytest.mark.parametrize("seed", range(4))
def test_an_obj_has_exactly_the_points_of_the_stl(seed: int) -> None:
    original = lump(seed)
    data = obj.write(surface(stl.write(original)))
    read = trimesh.load(io.BytesIO(data), file_type="obj", process=False)
    again = trimesh.load(io.BytesIO(stl.write(original)), file_type="stl")
    assert np.array_equal(read.triangles.astype(np.float32), again.triangles.astype(np.float32))
    assert read.is_watertight
    assert len(read.vertices) == len(original.vertices)
    assert obj.write(surface(stl.write(original))) == data
    assert {line[:2] for line in data.decode().splitlines()} == {"v ", "f "}


def test_numbers_are_short() -> None:
    points = np.array([[0.1, -0.0, 1.0], [1e-7, 20.0, 0.3], [0.5, 0.25, 123456.0]])
    data = obj.write(Surface(points, np.array([[0, 1, 2]])))
    assert data == b"v 0.1 0 1\nv 1e-07 20 0.3\nv 0.5 0.25 123456\nf 1 2 3\n"


def test_every_reader_takes_the_obj_files(kit: Kit, tmp_path: Path) -> None:
    robot, geometry, plan = built(kit, format="obj")
    assert {Path(name).suffix for name in geometry.files} == {".obj"}
    assert sorted(geometry.files) == sorted(shape.file for shape in geometry.shapes if shape.file)
    write(robot, tmp_path, plan, geometry)
    by_mjcf = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    by_urdf = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.urdf"))
    assert by_mjcf.nmesh == by_urdf.nmesh == len(geometry.files)
    model = pin.buildModelFromUrdf(str(tmp_path / "robot.urdf"))
    for kind in (pin.VISUAL, pin.COLLISION):
        shapes = pin.buildGeomFromUrdf(
            model, str(tmp_path / "robot.urdf"), kind, package_dirs=[str(tmp_path)]
        )
        assert shapes.ngeoms == 2
    assert [check for check in checked(tmp_path, robot, plan) if check.fails] == []


def test_without_assets_masses_and_primitives_stay(kit: Kit, tmp_path: Path) -> None:
    robot, geometry, plan = built(kit, assets="none")
    assert geometry.files == {}
    assert geometry.shapes == ()
    assert [(one.code, one.where) for one in geometry.diagnostics] == [
        ("I-NO-ASSETS", "mesh.assets"),
        ("W-NO-COLLIDER", "mesh.assets"),
    ]
    assert geometry.diagnostics[0].message.startswith("2 visual meshes and 2 colliders")
    write(robot, tmp_path, plan, geometry)
    assert not (tmp_path / "assets").exists()
    assert parse((tmp_path / "robot.urdf").read_bytes()).findall(".//mesh") == []
    assert parse((tmp_path / "robot.xml").read_bytes()).findall(".//mesh") == []
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert model.body_mass.sum() == pytest.approx(sum(link.inertial.mass for link in robot.links))
    assert [check for check in checked(tmp_path, robot, plan) if check.fails] == []


def test_by_part_each_part_has_its_mesh_and_its_name(kit: Kit, tmp_path: Path) -> None:
    robot, geometry, _ = built(kit, visual={"merge": "part"})
    parts = sum(len(link.parts) for link in robot.links)
    seen = [shape for shape in geometry.shapes if shape.role == "visual"]
    assert len(seen) == parts
    for link in robot.links:
        words = {shape.file.removeprefix(f"{link.name}_") for shape in seen if shape.link == link.name}
        assert len(words) == len(link.parts)
    assert sum(shape.faces for shape in seen) > 0


def test_names_of_parts_are_stable_and_unique() -> None:
    assert part_words(["Arm/Screw <1>", "Arm/Screw <2>", "Arm/Plate <1>"]) == ["screw", "screw_2", "plate"]
    assert part_words(["A/Pin <1>", "B/Pin <1>", "Plate <1>"]) == ["a_pin", "b_pin", "plate"]
    assert part_words(["Plate <1>", "Plate <1>", "Collision <1>"]) == [
        "plate__1",
        "plate__2",
        "part_collision",
    ]
    names = file_names({"arm": (["screw", "plate__1"], 2), "base": (1, 1)})
    assert names["arm"] == (
        ["arm_screw.stl", "arm_plate__1.stl"],
        ["arm_collision_1.stl", "arm_collision_2.stl"],
    )
    assert names["base"] == (["base.stl"], ["base_collision.stl"])


def two_arms(kit: Kit, **mesh: object) -> tuple[Robot, Geometry, object]:
    """A base with two equal arms, each held at its top."""
    base, left, right = kit.place("Base", fixed=True), kit.place("Left"), kit.place("Right")
    kit.root.revolute("One", (left, TOP), (base, SIDE), value=0.3, limits=(-1, 1))
    kit.root.revolute("Two", (right, TOP), (base, TOP), value=-0.2, limits=(-1, 1))
    robot, plan = robot_of(kit.document), plan_of(mesh=mesh)
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    return robot, geometry, plan


@pytest.mark.parametrize("form", ["stl", "obj"])
def test_meshes_of_the_same_content_are_one_file(kit: Kit, tmp_path: Path, form: str) -> None:
    robot, geometry, plan = two_arms(kit, format=form)
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
            found = _corners(model, geom)
            assert np.abs(found[:, None] - expected[None]).max(axis=2).min(axis=1).max() < 1e-6
            assert np.abs(found[:, None] - expected[None]).max(axis=2).min(axis=0).max() < 1e-6


def _corners(model: mujoco.MjModel, geom: int) -> np.ndarray:
    """The vertices of a geom's mesh in the frame of its body."""
    mesh = int(model.geom_dataid[geom])
    first = int(model.mesh_vertadr[mesh])
    points = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])]
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    return points @ turn.reshape(3, 3).T + model.geom_pos[geom]


def test_what_differs_in_colour_alone_is_one_mesh_but_for_its_texture() -> None:
    data = stl.write(lump(1))
    shapes = [
        Shape("b", "collision", "b_collision.stl", None, 3, 1, 1.0, 1.0),
        Shape("b", "visual", "b.stl", (1.0, 0.0, 0.0, 1.0), 3, 1, 1.0, 1.0),
        Shape("a", "visual", "a.stl", (0.0, 1.0, 0.0, 1.0), 3, 1, 1.0, 1.0),
        Shape("c", "visual", "c.stl", None, 3, 1, 1.0, 1.0),
    ]
    files = {"b_collision.stl": data, "b.stl": data, "a.stl": data, "c.stl": stl.write(lump(2))}
    section = plan_of().mesh
    (found, kept), _ = written(shapes, files, section)
    assert [shape.file for shape in found] == ["b.stl", "b.stl", "b.stl", "c.stl"]
    assert kept == {"b.stl": data, "c.stl": files["c.stl"]}
    assert [shape.colour for shape in found] == [shape.colour for shape in shapes]
    dressed = [replace(shape, texture="wood.png") for shape in shapes[1:3]]
    textured = {"b.stl": obj.write(lump(1)), "a.stl": obj.write(lump(1)), "wood.png": b"PNG"}
    (found, kept), _ = written([*dressed, replace(dressed[0], link="d", file="a.stl")], textured, section)
    assert [shape.file for shape in found] == ["b.obj", "a.obj", "b.obj"]
    assert sorted(kept) == ["a.mtl", "a.obj", "b.mtl", "b.obj", "wood.png"]
