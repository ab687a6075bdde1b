"""Mesh files as they are written: STL or OBJ, by colour or by part, or none at all."""

import io
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from stages.formats.xml import parse
from stages.mesh import make_geometry, obj, stl
from stages.mesh.assets import surface
from stages.mesh.names import file_names, part_words
from stages.mesh.surface import Surface, rounded
from stages.robot.geometry import Geometry
from stages.robot.model import Robot
from stages.validate import validate
from tests.support.building import bundle_of, plan_of, robot_of, write
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
    assert [check for check in validate(tmp_path, robot, plan) if not check.passed] == []


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
    assert [check for check in validate(tmp_path, robot, plan) if not check.passed] == []


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
