"""What a USD has for SimReady and for engines by their own schemas: read by `pxr`, MuJoCo and numpy alone."""

import json
import struct
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.export.usd.date import with_date
from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.files.stl import write as write_stl
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Actuator, Dynamics
from tests.support.building import NO_MESHES, plan_of, solid
from tests.support.exports import compiled, exported
from tests.support.robots import at, joint, robot_with
from tests.support.touching import ball
from tests.support.usd import complaints, pxr, stage_of
from tests.unit.export.test_usd import usd_export as usd_of

pytestmark = pytest.mark.usefixtures("no_thumbnails")

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
"""A tetrahedron, its faces outwards."""


def usd_export(robot, geometry=NO_MESHES, **usd):
    return usd_of(robot, geometry, export={"usd": usd, "mjcf": {}})


def meshed(*names):
    """One link's shapes: the first file is seen, the others collide; all have the same surface."""
    data = write_stl(Surface(CORNERS, FACES))
    seen = Shape("base", "visual", names[0], (1.0, 1.0, 1.0, 1.0), 4, 4, 1.0, 1.0)
    hulls = (replace(seen, role="collision", file=name, colour=None) for name in names[1:])
    return Geometry((seen, *hulls), dict.fromkeys(names, data))


def arm(count=2, **more):
    rows = [joint("revolute", "base", f"link_{n}", [0.4], name=f"joint_{n}") for n in range(count)]
    return replace(robot_with(rows), **more)


def prims(stage):
    return {str(prim.GetPath()): prim for prim in stage.Traverse(pxr.Usd.TraverseInstanceProxies())}


def meshes(stage):
    return {path: prim for path, prim in prims(stage).items() if prim.IsA(pxr.UsdGeom.Mesh)}


def visibilities(stage):
    return {path: pxr.UsdGeom.Imageable(prim).ComputeVisibility() for path, prim in meshes(stage).items()}


def applied(prim):
    return set(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def test_each_face_has_its_unit_normal_outwards(tmp_path):
    stage = stage_of(usd_export(arm(), meshed("part.stl")).files, tmp_path)
    assert complaints(stage) == []
    (mesh,) = map(pxr.UsdGeom.Mesh, meshes(stage).values())
    normals = pxr.UsdGeom.PrimvarsAPI(mesh).GetPrimvar("normals")
    assert normals.GetInterpolation() == "uniform"
    values = np.array(normals.ComputeFlattened())
    corners = np.array(mesh.GetPointsAttr().Get())[np.array(mesh.GetFaceVertexIndicesAttr().Get())]
    assert values.shape == (4, 3)
    assert np.abs(np.linalg.norm(values, axis=1) - 1).max() < 2e-5
    for normal, face in zip(values, corners.reshape(-1, 3, 3), strict=True):
        assert np.abs((face[1:] - face[0]) @ normal).max() < 5e-5
        assert (face.mean(axis=0) - CORNERS.mean(axis=0)) @ normal > 0


def test_face_without_area_has_a_normal_all_the_same(tmp_path):
    thin = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], dtype=float)
    files = {"part.stl": write_stl(Surface(thin, np.array([[0, 1, 2]])))}
    stage = stage_of(usd_export(arm(), replace(meshed("part.stl"), files=files)).files, tmp_path)
    (mesh,) = meshes(stage).values()
    normals = pxr.UsdGeom.PrimvarsAPI(mesh).GetPrimvar("normals").ComputeFlattened()
    assert [tuple(normal) for normal in normals] == [(0, 0, 1)]


def test_collider_that_is_also_seen_is_invisible(tmp_path):
    geometry = meshed("seen.stl", "same.stl", "other.stl")
    moved = {"other.stl": write_stl(Surface(CORNERS + 0.1, FACES))}
    stage = stage_of(usd_export(arm(), replace(geometry, files=geometry.files | moved)).files, tmp_path)
    assert visibilities(stage) == {
        "/robot/base/visuals/visual_1/mesh": "inherited",
        "/robot/base/collisions/collision_1": "invisible",
        "/robot/base/collisions/collision_2": "inherited",
    }
    for number in (1, 2):
        collider = prims(stage)[f"/robot/base/collisions/collision_{number}"]
        assert collider.HasAPI(pxr.UsdPhysics.CollisionAPI)
        assert pxr.UsdGeom.Imageable(collider).ComputePurpose() == "guide"


def test_mesh_of_two_links_at_a_place_is_visible_on_both(tmp_path):
    """A link may move away from the other: only what the same link shows twice is invisible."""
    own = meshed("base.stl", "part.stl", "hull.stl")
    roles = {"base.stl": "visual", "part.stl": "visual", "hull.stl": "collision"}
    shapes = tuple(
        replace(own.shapes[0], link=link, file=file, role=role)
        for link in ("base", "link_0")
        for file, role in roles.items()
    )
    robot = robot_with([joint("revolute", "base", "link_0", [0.0], name="joint_0")])
    stage = stage_of(usd_export(robot, replace(own, shapes=shapes)).files, tmp_path)
    seen = {"visuals/visual_1/mesh": "inherited", "visuals/visual_2/mesh": "invisible"}
    seen["collisions/collision_1"] = "invisible"
    expected = {f"/robot/{link}/{path}": seen[path] for link in ("base", "link_0") for path in seen}
    assert visibilities(stage) == expected


def test_colliders_have_the_schemas_of_newton_and_mujoco(tmp_path):
    robot = robot_with([joint("revolute", "base", "ball")], shapes={"ball": (ball(0.05, at(0, 0, 0.1)),)})
    mesh = meshed("seen.stl", "part.stl")
    geometry = replace(mesh, shapes=(*mesh.shapes, *solid(robot).shapes))
    stage = stage_of(usd_export(robot, geometry).files, tmp_path)
    both = {"PhysicsCollisionAPI", "NewtonCollisionAPI", "MjcCollisionAPI"}
    hull, sphere = (
        applied(stage.GetPrimAtPath(f"/robot/{link}/collisions/collision_1")) for link in ("base", "ball")
    )
    assert both | {"PhysicsMeshCollisionAPI", "NewtonMeshCollisionAPI"} <= hull
    assert both <= sphere
    assert "NewtonMeshCollisionAPI" not in sphere


ACTUATORS = (
    Actuator("servo", "joint_0", "position", kp=90, kv=3, force=(-7, 7), control=(-1, 1)),
    Actuator("geared", "joint_1", "position", gear=-2, kp=50, kv=3),
    Actuator("speed", "joint_2", "velocity", kv=8, control=(-2, 2)),
    Actuator("force", "joint_3", "motor", gear=3, control=(-2, 3)),
    Actuator("way", "joint_4", "intvelocity", kp=60, kv=2, terms=(("actrange", "-1 1.5"),)),
    Actuator("brake", "joint_5", "damper", kv=1, control=(0, 1)),
    Actuator(
        "own", "joint_6", "general",
        terms=(
            ("dyntype", "filter"), ("biastype", "affine"), ("dynprm", "0.1"), ("gainprm", "5"),
            ("biasprm", "1 -5"),
        ),
    ),
)  # fmt: skip


DYNAMICS = ("none", "integrator", "filter", "filterexact")


def value(prim, name, default=None):
    attribute = prim.GetAttribute(f"mjc:{name}")
    return attribute.Get() if attribute else default


def test_each_actuator_is_what_mujoco_compiles_of_it(tmp_path):
    result = usd_export(arm(7, actuators=ACTUATORS))
    stage, model = stage_of(result.files, tmp_path), compiled(result)
    nodes = [prim for prim in prims(stage).values() if prim.GetTypeName() == "MjcActuator"]
    assert [prim.GetName() for prim in nodes] == [actuator.name for actuator in ACTUATORS]
    zeros, unit = [0.0] * 10, [1.0] + [0.0] * 9
    defaults = {"gainPrm": unit, "biasPrm": zeros, "dynPrm": unit, "gear": unit[:6]}
    for prim in nodes:
        index = model.actuator(prim.GetName()).id
        (target,) = prim.GetRelationship("mjc:target").GetTargets()
        assert target.name == model.joint(model.actuator_trnid[index, 0]).name
        assert "MjcJointAPI" in applied(stage.GetPrimAtPath(target))
        for name, default in defaults.items():
            expected = getattr(model, f"actuator_{name.lower()}")[index]
            assert list(value(prim, name, default)) == pytest.approx(list(expected))
        assert value(prim, "dynType", "none") == DYNAMICS[model.actuator_dyntype[index]]
        assert value(prim, "gainType", "fixed") == ("fixed", "affine")[model.actuator_gaintype[index]]
        assert value(prim, "biasType", "none") == ("none", "affine")[model.actuator_biastype[index]]
        for kind in ("ctrl", "force", "act"):
            ends, limited = (getattr(model, f"actuator_{kind}{end}")[index] for end in ("range", "limited"))
            said = [value(prim, f"{kind}Range:{end}") for end in ("min", "max")]
            assert said == (list(ends) if limited else [None, None]), (prim.GetName(), kind)


def test_actuator_that_the_schema_does_not_know_is_left_out(tmp_path):
    own = (("biastype", "user"), ("gaintype", "other"))
    robot = arm(1, actuators=(Actuator("odd", "joint_0", "general", terms=own),))
    stage = stage_of(exported(robot, export={"usd": {}}).files, tmp_path)
    assert not [prim for prim in stage.Traverse() if prim.GetTypeName() == "MjcActuator"]


def test_joints_have_mujocos_numbers_in_radians(tmp_path):
    dynamics = Dynamics(damping=0.3, friction=0.2, armature=0.05, effort=4.0)
    result = usd_export(robot_with([joint("revolute", "base", "arm", [0.4], dynamics=dynamics)]))
    stage, model = stage_of(result.files, tmp_path), compiled(result)
    prim = stage.GetPrimAtPath("/robot/joints/arm_joint")
    hinge = model.joint("arm_joint")
    low, high = model.jnt_actfrcrange[hinge.id]
    numbers = {
        "armature": hinge.armature[0],
        "damping": hinge.damping[0],
        "frictionloss": hinge.frictionloss[0],
    }
    numbers |= {"actuatorfrcrange:min": low, "actuatorfrcrange:max": high}
    for name, expected in numbers.items():
        attribute = prim.GetAttribute(f"mjc:{name}")
        assert attribute.Get() == pytest.approx(expected), name
        assert attribute.GetVariability() == pxr.Sdf.VariabilityUniform
        assert attribute.GetTypeName() == "double"


def test_joint_that_nothing_drives_has_a_drive_without_force(tmp_path):
    stage = stage_of(usd_export(arm(1)).files, tmp_path)
    drive = pxr.UsdPhysics.DriveAPI(stage.GetPrimAtPath("/robot/joints/joint_0"), "angular")
    assert (drive.GetStiffnessAttr().Get(), drive.GetDampingAttr().Get()) == (0, 0)
    assert 0 < drive.GetMaxForceAttr().Get() < float("inf")


def metadata_of(stage):
    return dict(stage.GetRootLayer().customLayerData["SimReady_Metadata"])


def test_metadata_are_the_robots(tmp_path):
    robot = arm()
    said = {"author": "Ada", "license": "MIT", "category": "arm", "qcode": "Q42", "date": "2026-01-02"}
    result = usd_export(robot, meshed("part.stl"), **said)
    stage = stage_of(result.files, tmp_path)
    values = metadata_of(stage)
    # A validator reads `robot.json` beside `robot.usda` as more metadata, and no key may be in both.
    assert not values.keys() & json.loads(result.files["robot.json"]).keys()
    bounds = pxr.UsdGeom.BBoxCache(pxr.Usd.TimeCode.Default(), ["default"])
    box = bounds.ComputeWorldBound(stage.GetDefaultPrim()).ComputeAlignedRange()
    assert list(values.pop("asset_extents")) == pytest.approx(list(box.GetSize()), abs=1e-5)
    assert values.pop("mass") == pytest.approx(sum(link.inertial.mass for link in robot.links))
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(pxr.UsdPhysics.RigidBodyAPI)]
    assert values.pop("rigid_body_count") == len(bodies)
    assert values == {
        "author": "Ada", "asset_name": "robot", "asset_type": "robot", "asset_license": "MIT",
        "category": "arm", "source_file": robot.provenance.document, "usd_date_generated": "2026-01-02",
        "qcode": "Q42",
    }  # fmt: skip
    # They claim nothing that is not said.
    bare = metadata_of(stage_of(usd_export(arm()).files, tmp_path / "bare"))
    assert {bare[key] for key in ("author", "asset_license", "usd_date_generated")} == {"unspecified"}
    assert list(bare["asset_extents"]) == [0, 0, 0]


def test_date_is_that_of_the_key_else_of_the_environment():
    def date(environ, **usd):
        return with_date(plan_of(export={"usd": usd}), environ).export.usd.date

    epoch = {"SOURCE_DATE_EPOCH": "1767312000"}
    assert (date(epoch), date(epoch, date="yesterday")) == ("2026-01-02", "yesterday")
    assert date({}) is None
    without = plan_of(export={"urdf": {}})
    assert with_date(without, epoch) is without
    for text in ("now", "", "9" * 30):
        with pytest.raises(ConfigError, match="SOURCE_DATE_EPOCH"):
            date({"SOURCE_DATE_EPOCH": text})


@pytest.mark.parametrize("geometry", [NO_MESHES, meshed("part.stl")], ids=["bones", "mesh"])
def test_thumbnail_shows_the_robot_and_is_the_same_each_time(geometry, monkeypatch):
    """The picture beside a USD, which a process of its own draws."""
    monkeypatch.undo()
    files, again = (usd_export(arm(), geometry).files for _ in range(2))
    picture = files[".thumbs/256x256/robot.usda.png"]
    assert picture[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", picture[16:24]) == (256, 256)
    # Of one colour a picture of this size has some hundred bytes.
    assert len(picture) > 2000
    assert files == again
