"""Colliders: a link may have several, meshes and primitives, whatever makes them."""

import math
from dataclasses import asdict, dataclass, replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.meshes.surface import Surface, transform_surface
from linkwright.stages.formats.xml import parse
from linkwright.stages.mesh import COLLIDERS, Maker, fit, make_geometry
from linkwright.stages.mesh.collide import collision
from linkwright.stages.mesh.collide.choices import Choice
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.make import ColliderJob
from linkwright.stages.mesh.colliders import hull, primitives, raw, spheres
from linkwright.stages.mesh.configuration.collider_settings import (
    HullSettings,
    PrimitiveSettings,
    RawSettings,
    SphereSettings,
)
from linkwright.stages.mesh.files import stl
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.link_mesh import PlacedMesh
from linkwright.stages.mesh.makers import MAKERS
from linkwright.stages.mesh.section import MeshSection
from linkwright.stages.mesh.surfaces import pieces
from linkwright.stages.robot import codec
from linkwright.stages.robot.model.geometry import Measures
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import MeshRef, Primitive, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.targets.engines import shape_limits
from tests.support.building import bundle_of, plan_of, robot_of, shaped, write
from tests.support.cases import mostly_slow
from tests.support.checked import checked
from tests.support.kit import hinged
from tests.support.places import PROJECT
from tests.support.solids import box, of_mesh
from tests.support.touching import Memory

KINDS = {
    int(getattr(mujoco.mjtGeom, f"mjGEOM_{kind.upper()}")): kind
    for kind in ("sphere", "capsule", "box", "cylinder")
}
BALL = Primitive("sphere", (0.02,), frozen(np.eye(4)))


def tetrahedron(size):
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * size
    return Surface(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))


def test_every_collider_of_the_table_is_a_module_and_an_option():
    modules = {file.stem for file in (PROJECT / "stages/mesh/colliders").glob("*.py")} - {"__init__"}
    assert {*COLLIDERS, "given"} == modules
    for name in COLLIDERS:
        assert MeshSection.model_validate({"collider": name}).collider == name
        assert (PROJECT / "conf/mesh" / f"{name}.yaml").is_file()


@dataclass(frozen=True, slots=True)
class SmoothedSettings(HullSettings):
    smoothing: float = 0.0


def test_new_setting_of_a_maker_is_in_its_memo_key(monkeypatch):
    monkeypatch.setitem(COLLIDERS, "hull", Maker("link", SmoothedSettings))

    def identity(**more):
        choice = Choice.of("hull", {"tolerance": None, "max_vertices": 64, "effort": "low", **more})
        use = PlacedMesh(MeshRef("reply", "part"), np.eye(4))
        return ColliderJob("arm", "arm", choice, (use,), (0,)).identity()

    assert identity(smoothing=0.0) == identity(smoothing=0.0, effort="high")
    assert identity(smoothing=0.0) != identity(smoothing=0.1)


def test_raw_colliders_are_the_surfaces_as_they_are():
    surfaces = [tetrahedron(0.5), tetrahedron(0.25)]
    result = raw.make(surfaces, RawSettings())
    for file, surface in zip(collision.colliders(result, np.eye(4)), surfaces, strict=True):
        assert isinstance(file, MeshFile)
        corners = surface.corners.reshape(-1, 9).tolist()
        assert sorted(stl.read(file.data).reshape(-1, 9).tolist()) == sorted(corners)
        assert file.colour is None


def test_tolerance_is_the_key_or_depends_on_the_size():
    small, large = tetrahedron(0.01), tetrahedron(1.0)
    assert SphereSettings().tolerance_of(small) == 0.001
    assert SphereSettings().tolerance_of(large) == pytest.approx(0.015 * math.sqrt(3))
    assert SphereSettings(tolerance=0.004).tolerance_of(large) == 0.004


@pytest.mark.parametrize(("collider", "codes"), [("visual", []), ("raw", ["I-RAW"])])
def test_raw_meshes_are_reported_and_missing_colliders_are_not(kit, collider, codes):
    hinged(kit)
    _, geometry, _ = shaped(kit.document, mesh={"collider": collider})
    assert [problem.code for problem in geometry.diagnostics] == codes
    assert bool(geometry.shapes_of("arm", "collision")) == (collider == "raw")


def test_settings_that_a_maker_reads_are_part_of_its_key(kit):
    hinged(kit)
    robot, bundle = robot_of(kit.document), bundle_of(kit.document)

    def keys(**mesh):
        memo = Memory()
        make_geometry(robot, bundle, plan_of(mesh={"collider": "hull", **mesh}), memo)
        return set(memo.keys_of("mesh.collider"))

    assert len(keys()) == 2
    assert keys(tolerance=0.1, extra_volume=0.5) == keys()
    assert not keys(max_vertices=8) & keys()


def test_collision_travels_as_bytes():
    measures = Measures(0.1, 0.2, "boolean", 1e-3, 2e-3, 3e-3, 4e-3)
    solid = tetrahedron(0.5)
    original = Collision((solid, BALL, solid), 4, measures, "pieces", 1e-3, False, "a note", True)
    again = collision.decode(collision.encode(original))
    assert codec.plain_data(again.pieces[1]) == codec.plain_data(BALL)
    for piece in again.pieces[::2]:
        assert np.array_equal(piece.corners, solid.corners)
    assert asdict(replace(again, pieces=())) == asdict(replace(original, pieces=()))


def test_link_with_several_colliders_has_them_all_in_every_file(kit, tmp_path, monkeypatch):
    def three_pieces(surfaces, settings):
        return Collision((*hull.make(surfaces, settings).pieces, BALL, tetrahedron(0.02)))

    monkeypatch.setitem(MAKERS, "hull", SimpleNamespace(make=three_pieces))
    hinged(kit)
    robot, geometry, plan = shaped(kit.document)
    # The last has the same bytes as that of the base.
    names = ["arm_collision_1.stl", None, "base_collision_2.stl"]
    assert [shape.file for shape in geometry.shapes_of("arm", "collision")] == names
    write(robot, tmp_path, plan, geometry)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    kinds = [KINDS.get(int(model.geom(f"arm_collision_{number}").type[0]), "mesh") for number in range(3)]
    shapes = parse((tmp_path / "robot.urdf").read_bytes()).findall("link[@name='arm']/collision/geometry/*")
    assert kinds == [shape.tag for shape in shapes] == ["mesh", "sphere", "mesh"]
    assert [check for check in checked(tmp_path, robot, plan) if check.fails] == []


def skewed(surfaces, settings):
    """A fit of each kind of a part that is turned out of the axes."""
    turn = rotation_from_rpy((0.4, -0.7, 1.1))
    stretched = Surface(surfaces[0].vertices * [1, 1.5, 2.5], surfaces[0].triangles)
    fits = fit.fits(transform_surface(stretched, from_parts(turn, np.zeros(3))))
    return Collision(tuple(fitted.primitive for fitted in fits))


def test_fitted_primitives_are_in_both_files_where_they_fit(kit, tmp_path, monkeypatch):
    monkeypatch.setitem(MAKERS, "hull", SimpleNamespace(make=skewed))
    hinged(kit)
    robot, geometry, plan = shaped(kit.document, ground={"kind": "none"})
    write(robot, tmp_path, plan, geometry)
    fitted = [shape.primitive for shape in geometry.shapes_of("arm", "collision")]
    assert [primitive.kind for primitive in fitted] == ["sphere", "capsule", "box", "cylinder"]
    where = robot.world_from_root @ link_poses(robot)["arm"]
    in_mjcf, in_urdf = (shapes_of(tmp_path / name, "arm") for name in ("robot.xml", "robot.urdf"))
    assert len(in_mjcf) == len(fitted)
    assert [piece.kind for piece in in_urdf] == ["sphere", "cylinder", "sphere", "sphere", "box", "cylinder"]
    points = where[:3, 3] + np.random.default_rng(0).uniform(-0.2, 0.2, (300, 3))
    # URDF has a cylinder and two balls for a capsule: outside, the nearest of them is as far.
    for primitive, written, parts in zip(fitted, in_mjcf, ((0,), (1, 2, 3), (4,), (5,)), strict=True):
        distances = pieces.signed_distance(pieces.placed(primitive, where), points)
        assert np.abs(distances - pieces.signed_distance(written, points)).max() < 1e-9
        near = np.min([pieces.signed_distance(in_urdf[part], points) for part in parts], axis=0)
        assert np.abs(distances - near)[distances > 0].max() < 1e-9


def shapes_of(file, link):
    """The colliding primitives of a link as MuJoCo reads a file, in the world."""
    spec = mujoco.MjSpec.from_file(str(file))
    spec.compiler.fusestatic = spec.compiler.discardvisual = False
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    shapes = []
    for index in range(model.ngeom):
        geom = model.geom(index)
        kind = KINDS.get(int(geom.type[0]))
        collides = geom.contype[0] or geom.conaffinity[0]
        if kind and collides and model.body(int(geom.bodyid[0])).name == link:
            pose = from_parts(data.geom_xmat[index].reshape(3, 3), data.geom_xpos[index])
            size = {"sphere": geom.size[:1], "box": 2 * geom.size}.get(kind, geom.size[:2] * [1, 2])
            shapes.append(Primitive(kind, tuple(map(float, size)), frozen(pose)))
    return shapes


@pytest.mark.parametrize(("target", "round_kind"), [("mujoco", {"cylinder"}), ("mjx", {"capsule", "box"})])
def test_each_part_has_the_primitive_that_fits_it_best(target, round_kind):
    settings = PrimitiveSettings(limits=shape_limits([target]))
    parts = of_mesh(trimesh.creation.cylinder(0.01, 0.05)), box(0.1, 0.05, 0.01)
    rod, plate = (primitives.make([part], settings).pieces[0].kind for part in parts)
    assert plate == "box"
    assert rod in round_kind


@pytest.mark.parametrize(("tolerance", "most"), mostly_slow([(0.001, 64), (0.003, 12), (0.0005, 64)], 2))
def test_spheres_keep_the_tolerance_where_they_can(tolerance, most):
    """They neither stand out of a convex surface nor leave it bare by more than the tolerance."""
    surface = box(0.03, 0.01, 0.01)
    balls = spheres.make([surface], SphereSettings(tolerance=tolerance)).pieces
    assert 0 < len(balls) <= most
    if tolerance >= 0.001:
        mesh = trimesh.Trimesh(surface.vertices, surface.triangles)
        points, _ = trimesh.sample.sample_surface(mesh, 4000, seed=1)
        assert np.min([pieces.signed_distance(ball, points) for ball in balls], axis=0).max() <= tolerance
        normals, heights = pieces.half_spaces(surface)
        middles = np.array([ball.link_from_shape[:3, 3] for ball in balls])
        reach = (middles @ normals.T - heights).max(axis=1) + [ball.size[0] for ball in balls]
        assert reach.max() <= tolerance


@pytest.mark.slow
def test_order_of_triangles_does_not_matter_to_spheres():
    surface = of_mesh(trimesh.creation.annulus(0.01, 0.02, 0.01))
    shuffled = Surface(surface.vertices, np.random.default_rng(1).permutation(surface.triangles))
    first, second = (spheres.make([part], SphereSettings()).pieces for part in (surface, shuffled))
    assert codec.plain_data(first) == codec.plain_data(second)
