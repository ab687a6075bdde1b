"""Colliders: a link may have several, meshes and primitives, whatever makes them."""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

import mujoco
import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.meshes.surface import Surface, moved
from linkwright.stages.formats.xml import parse
from linkwright.stages.mesh import COLLIDERS, Maker, fit, make_geometry
from linkwright.stages.mesh.collide import collision
from linkwright.stages.mesh.collide.choices import Choice
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.make import ColliderJob
from linkwright.stages.mesh.colliders import hull, primitives, raw, spheres
from linkwright.stages.mesh.configuration.collider_settings import (
    ColliderSettings,
    HullSettings,
    PrimitiveSettings,
    SphereSettings,
)
from linkwright.stages.mesh.files import stl
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.link_mesh import Use
from linkwright.stages.mesh.makers import MAKERS
from linkwright.stages.mesh.section import MeshSection
from linkwright.stages.mesh.surfaces import pieces
from linkwright.stages.robot import codec
from linkwright.stages.robot.model.geometry import Measures
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import MeshRef, Primitive, PrimitiveKind, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.support.building import bundle_of, plan_of, robot_of, write
from tests.support.checked import checked
from tests.support.kit import SIDE, TOP, Kit
from tests.support.places import PROJECT

KINDS: dict[int, PrimitiveKind] = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
}

BALL = Primitive("sphere", (0.02,), frozen(np.eye(4)))


def three_pieces(surfaces: Sequence[Surface], settings: HullSettings) -> Collision:
    (whole,) = hull.make(surfaces, settings).pieces
    return Collision((whole, BALL, tetrahedron(0.02)))


def test_every_collider_of_the_table_is_a_module_and_an_option() -> None:
    modules = {file.stem for file in (PROJECT / "stages/mesh/colliders").glob("*.py")} - {"__init__"}
    assert {*COLLIDERS, "given"} == modules
    for name in COLLIDERS:
        assert MeshSection.model_validate({"collider": name}).collider == name
        assert (PROJECT / "conf/mesh" / f"{name}.yaml").is_file()


def tetrahedron(size: float) -> Surface:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * size
    return Surface(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))


@dataclass(frozen=True, slots=True)
class SmoothedSettings(HullSettings):
    smoothing: float = 0.0


def test_a_new_setting_of_a_maker_is_in_its_memo_key(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(COLLIDERS, "hull", Maker("link", SmoothedSettings))  # type: ignore[misc]
    values = {"tolerance": None, "max_vertices": 64, "effort": "low"}
    use = Use(MeshRef("reply", "part"), np.eye(4))

    def identity(**more: Any) -> str:
        choice = Choice.of("hull", {**values, **more})
        return ColliderJob("arm", "arm", choice, (use,), (0,)).identity()

    assert identity(smoothing=0.0) == identity(smoothing=0.0, effort="high")
    assert identity(smoothing=0.0) != identity(smoothing=0.1)


def test_raw_colliders_are_the_surfaces_as_they_are() -> None:
    surfaces = [tetrahedron(0.5), tetrahedron(0.25)]
    made = raw.make(surfaces, ColliderSettings())
    for file, surface in zip(collision.colliders(made, np.eye(4)), surfaces, strict=True):
        assert isinstance(file, MeshFile)
        corners = surface.corners.reshape(-1, 9).tolist()
        assert sorted(stl.read(file.data).reshape(-1, 9).tolist()) == sorted(corners)
        assert file.colour is None


def test_the_tolerance_is_what_the_key_says_else_by_the_size() -> None:
    small, large = tetrahedron(0.01), tetrahedron(1.0)
    assert SphereSettings().tolerance_of(small) == 0.001
    assert SphereSettings().tolerance_of(large) == pytest.approx(0.015 * math.sqrt(3))
    assert SphereSettings(tolerance=0.004).tolerance_of(large) == 0.004


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


def test_the_settings_that_a_maker_reads_are_part_of_its_key(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), limits=(-1, 1))
    robot, bundle = robot_of(kit.document), bundle_of(kit.document)

    def keys(**mesh: object) -> list[str]:
        found: list[str] = []

        def memo(kind: str, key: Mapping[str, Any], make: Callable[[], bytes]) -> bytes:
            if kind == "mesh.collider":
                found.append(json.dumps(key))
            return make()

        make_geometry(robot, bundle, plan_of(mesh={"collider": "hull", **mesh}), memo)
        return found

    assert len(set(keys())) == 2
    assert keys(tolerance=0.1, extra_volume=0.5) == keys()
    assert not set(keys(max_vertices=8)) & set(keys())


def test_a_collision_travels_as_bytes() -> None:
    measures = Measures(0.1, 0.2, "boolean", 1e-3, 2e-3, 3e-3, 4e-3)
    solid = tetrahedron(0.5)
    made = Collision((solid, BALL, solid), 4, measures, "pieces", 1e-3, False, "a note", True)
    again = collision.decode(collision.encode(made))
    assert codec.plain(again.pieces[1]) == codec.plain(BALL)
    for one in again.pieces[::2]:
        assert isinstance(one, Surface)
        assert np.array_equal(one.corners, solid.corners)
    assert asdict(replace(again, pieces=())) == asdict(replace(made, pieces=()))


def test_a_link_with_several_colliders_has_them_all_in_every_file(
    kit: Kit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=(-1, 1))
    monkeypatch.setitem(MAKERS, "hull", SimpleNamespace(make=three_pieces))
    robot, plan = robot_of(kit.document), plan_of()
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    assert [shape.file for shape in geometry.of("arm", "collision")] == [
        "arm_collision_1.stl",
        None,
        "base_collision_2.stl",  # the same bytes
    ]
    write(robot, tmp_path, plan, geometry)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    kinds = [int(model.geom(f"arm_collision_{count}").type[0]) for count in range(3)]
    assert kinds == [mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_MESH]
    shapes = parse((tmp_path / "robot.urdf").read_bytes()).findall("link[@name='arm']/collision/geometry/*")
    assert [shape.tag for shape in shapes] == ["mesh", "sphere", "mesh"]
    assert [check for check in checked(tmp_path, robot, plan) if check.fails] == []


def skewed(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """A fit of each kind of a part that is turned out of the axes."""
    turn = rotation_from_rpy((0.4, -0.7, 1.1))
    stretched = Surface(surfaces[0].vertices * [1, 1.5, 2.5], surfaces[0].triangles)
    return Collision(
        tuple(one.primitive for one in fit.fits(moved(stretched, from_parts(turn, np.zeros(3)))))
    )


def test_fitted_primitives_are_in_the_mjcf_and_the_urdf_where_they_were_fitted(
    kit: Kit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), limits=(-1, 1))
    monkeypatch.setitem(MAKERS, "hull", SimpleNamespace(make=skewed))
    robot, plan = robot_of(kit.document), plan_of(ground={"kind": "none"})
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    write(robot, tmp_path, plan, geometry)
    ours = [shape.primitive for shape in geometry.of("arm", "collision")]
    assert [one.kind for one in ours if one] == ["sphere", "capsule", "box", "cylinder"]
    where = robot.world_from_root @ link_poses(robot)["arm"]
    written = shapes_of(tmp_path / "robot.xml", "arm")
    assert len(written) == len(ours)
    from_urdf = shapes_of(tmp_path / "robot.urdf", "arm")
    assert [one.kind for one in from_urdf] == ["sphere", "cylinder", "sphere", "sphere", "box", "cylinder"]
    points = where[:3, 3] + np.random.default_rng(0).uniform(-0.2, 0.2, (300, 3))
    for index, one in enumerate(ours):
        placed = pieces.placed(one, where)
        assert isinstance(placed, Primitive)
        distances = pieces.signed_distance(placed, points)
        assert np.abs(distances - pieces.signed_distance(written[index], points)).max() < 1e-9
        parts = {0: (0,), 1: (1, 2, 3), 2: (4,), 3: (5,)}[index]
        # URDF has a cylinder and two balls for a capsule: outside, the nearest of them is as far.
        near = np.min([pieces.signed_distance(from_urdf[part], points) for part in parts], axis=0)
        outside = distances > 0
        assert np.abs(distances - near)[outside].max() < 1e-9


def shapes_of(file: Path, link: str) -> list[Primitive]:
    """The colliding primitives of a link as MuJoCo reads a file, in the world."""
    spec = mujoco.MjSpec.from_file(str(file))
    spec.compiler.fusestatic = False
    spec.compiler.discardvisual = False
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    found = []
    for index in range(model.ngeom):
        geom = model.geom(index)
        kind = KINDS.get(int(geom.type[0]))
        if kind is None or (not geom.contype[0] and not geom.conaffinity[0]):
            continue
        if model.body(int(geom.bodyid[0])).name != link:
            continue
        pose = from_parts(data.geom_xmat[index].reshape(3, 3), data.geom_xpos[index])
        radii = geom.size
        size = {"sphere": radii[:1], "box": 2 * radii}.get(kind, radii[:2] * [1, 2])
        found.append(Primitive(kind, tuple(map(float, size)), frozen(pose)))
    return found


@pytest.mark.parametrize("target", ["mujoco", "mjx"])
def test_each_part_has_the_primitive_that_fits_it_best(target: Literal["mujoco", "mjx"]) -> None:
    rod = Surface(*solid(trimesh.creation.cylinder(0.01, 0.05)))
    box = Surface(*solid(trimesh.creation.box((0.1, 0.05, 0.01))))
    settings = PrimitiveSettings(target=target)
    made = [primitives.make([one], settings).pieces[0] for one in (rod, box)]
    kinds = [one.kind for one in made if isinstance(one, Primitive)]
    assert kinds[1] == "box"
    assert (kinds[0] == "cylinder") == (target == "mujoco")


def test_spheres_keep_the_tolerance_where_they_can() -> None:
    surface = Surface(*solid(trimesh.creation.box((0.03, 0.01, 0.01))))
    for tolerance, count in ((0.001, 64), (0.0005, 64), (0.003, 12)):
        made = spheres.make([surface], SphereSettings(tolerance=tolerance))
        balls = [one for one in made.pieces if isinstance(one, Primitive)]
        assert 0 < len(balls) <= count
        if tolerance >= 0.001:
            assert_within(balls, surface, tolerance)


def assert_within(balls: Sequence[Primitive], surface: Surface, tolerance: float) -> None:
    """The balls neither stand out of a convex surface nor leave it bare by more than this [m]."""
    mesh = trimesh.Trimesh(surface.vertices, surface.triangles)
    points, _ = trimesh.sample.sample_surface(mesh, 4000, seed=1)
    assert np.min([pieces.signed_distance(one, points) for one in balls], axis=0).max() <= tolerance
    normals, heights = pieces.half_spaces(surface)
    for ball in balls:
        reach = (normals @ ball.link_from_shape[:3, 3] - heights).max() + ball.size[0]
        assert reach <= tolerance


@pytest.mark.slow
def test_the_order_of_triangles_does_not_matter_to_spheres() -> None:
    surface = Surface(*solid(trimesh.creation.annulus(0.01, 0.02, 0.01)))
    shuffled = Surface(surface.vertices, np.random.default_rng(1).permutation(surface.triangles))
    one, other = (spheres.make([it], SphereSettings()).pieces for it in (surface, shuffled))
    assert [codec.plain(ball) for ball in one] == [codec.plain(ball) for ball in other]


def solid(mesh: trimesh.Trimesh) -> tuple[Any, Any]:
    return np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64)
