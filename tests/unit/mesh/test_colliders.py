"""Colliders: a link may have several, meshes and primitives, whatever makes them."""

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from stages.formats.xml import parse
from stages.mesh import COLLIDERS, link_mesh, make_geometry, stl
from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.colliders import hull, raw
from stages.mesh.keys import MeshSection
from stages.mesh.link_mesh import Collider, LinkMesh
from stages.mesh.mesh_file import MeshFile
from stages.mesh.surface import Surface
from stages.robot import codec
from stages.robot.model import Primitive, frozen
from stages.validate import validate
from tests.support.building import bundle_of, plan_of, robot_of, write
from tests.support.kit import SIDE, TOP, Kit
from tests.support.places import PROJECT

BALL = Primitive("sphere", (0.02,), frozen(np.eye(4)))


def hull_ball_hull(surfaces: Sequence[Surface], settings: ColliderSettings) -> tuple[Collider, ...]:
    (whole,) = hull.make(surfaces, settings)
    return whole, BALL, whole


def test_every_collider_of_the_table_is_a_module_and_an_option() -> None:
    modules = {file.stem for file in (PROJECT / "stages/mesh/colliders").glob("*.py")} - {"__init__"}
    assert set(COLLIDERS) == modules
    for name in COLLIDERS:
        assert MeshSection.model_validate({"collider": name}).collider == name
        assert (PROJECT / "conf/mesh" / f"{name}.yaml").is_file()


def tetrahedron(size: float) -> Surface:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * size
    return Surface(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))


def test_raw_colliders_are_the_surfaces_as_they_are() -> None:
    surfaces = [tetrahedron(0.5), tetrahedron(0.25)]
    files = raw.make(surfaces, ColliderSettings())
    for file, surface in zip(files, surfaces, strict=True):
        assert isinstance(file, MeshFile)
        corners = surface.corners.reshape(-1, 9).tolist()
        assert sorted(stl.read(file.data).reshape(-1, 9).tolist()) == sorted(corners)
        assert file.colour is None


def test_the_tolerance_is_what_the_key_says_else_by_the_size() -> None:
    small, large = tetrahedron(0.01), tetrahedron(1.0)
    assert ColliderSettings().tolerance_of([small]) == 0.001
    assert ColliderSettings().tolerance_of([small, large]) == pytest.approx(0.015 * math.sqrt(3))
    assert ColliderSettings(tolerance=0.004).tolerance_of([large]) == 0.004


@pytest.mark.parametrize(("collider", "codes"), [("visual", []), ("raw", ["I-RAW"])])
def test_without_colliders_nothing_is_missing_and_raw_meshes_are_reported(
    kit: Kit, collider: str, codes: list[str]
) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), limits=(-1, 1))
    plan = plan_of(mesh={"collider": collider})
    robot = robot_of(kit.document)
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    assert [problem.code for problem in geometry.diagnostics] == codes
    assert bool(geometry.of("arm", "collision")) == (collider == "raw")


def test_the_settings_that_a_maker_reads_are_part_of_its_key(
    kit: Kit, monkeypatch: pytest.MonkeyPatch
) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), limits=(-1, 1))
    monkeypatch.setitem(COLLIDERS, "hull", ("extra_volume", "max_vertices"))  # type: ignore[arg-type]
    keys: list[object] = []

    def memo(kind: str, key: Mapping[str, Any], make: Callable[[], bytes]) -> bytes:
        keys.append(key["settings"])
        return make()

    make_geometry(robot_of(kit.document), bundle_of(kit.document), plan_of(), memo)
    assert keys == [{"extra_volume": 0.15, "max_vertices": 64}] * 2


def test_colliders_of_both_kinds_are_kept_as_bytes() -> None:
    seen = MeshFile((1.0, 0.5, 0.0, 1.0), 3, 1, 0.5, 0.0, b"seen")
    solid = MeshFile(None, 4, 4, 1, 1, b"solid")
    link = LinkMesh((seen, seen), (solid, BALL, solid), (link_mesh.Finding(True, 0.5),))
    again = link_mesh.decode(link_mesh.encode(link))
    assert codec.plain(again.colliders[1]) == codec.plain(BALL)
    assert again.visuals == (seen, seen)
    assert again.colliders[::2] == (solid, solid)
    assert again.findings == link.findings


def test_a_link_with_several_colliders_has_them_all_in_every_file(
    kit: Kit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=(-1, 1))
    monkeypatch.setitem(sys.modules, "stages.mesh.colliders.hull", SimpleNamespace(make=hull_ball_hull))
    robot, plan = robot_of(kit.document), plan_of()
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    assert [shape.file for shape in geometry.of("arm", "collision")] == [
        "arm_collision_1.stl",
        None,
        "arm_collision_2.stl",
    ]
    write(robot, tmp_path, plan, geometry)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    kinds = [int(model.geom(f"arm_collision_{count}").type[0]) for count in range(3)]
    assert kinds == [mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_MESH]
    shapes = parse((tmp_path / "robot.urdf").read_bytes()).findall("link[@name='arm']/collision/geometry/*")
    assert [shape.tag for shape in shapes] == ["mesh", "sphere", "mesh"]
    assert [check for check in validate(tmp_path, robot, plan) if not check.passed] == []
