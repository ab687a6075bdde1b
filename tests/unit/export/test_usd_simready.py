"""What a USD has for SimReady and for engines by their own schemas: read by `pxr`, MuJoCo and numpy alone."""

import json
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.stages.export.usd.date import with_date
from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.collide.primitives import shapes as primitive_shapes
from linkwright.stages.mesh.files.stl import write as write_stl
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Actuator, Dynamics, Primitive, frozen
from tests.support.building import NO_MESHES, plan_of
from tests.support.exports import compiled, exported
from tests.support.robots import at, joint, robot_with
from tests.support.usd import complaints, pxr, stage_of

pytestmark = pytest.mark.usefixtures("no_thumbnails")

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
"""A tetrahedron, its faces outwards."""


def usd_export(robot, geometry=NO_MESHES, **usd):
    assert pxr.Usd
    keys = {"export": {"usd": usd, "mjcf": {}}, "ground": {"kind": "none"}}
    return exported(robot, geometry, **keys)


def meshed(*names):
    """One link's shapes: the first file is seen, the others collide; all have the same surface."""
    data = write_stl(Surface(CORNERS, FACES))
    roles = ["visual", *["collision"] * (len(names) - 1)]
    shapes = tuple(
        Shape("base", role, name, (1.0, 1.0, 1.0, 1.0) if role == "visual" else None, 4, 4, 1.0, 1.0)
        for role, name in zip(roles, names, strict=True)
    )
    return Geometry(shapes, dict.fromkeys(names, data))


def arm(count=2, **more):
    rows = [joint("revolute", "base", f"link_{n}", [0.4], name=f"joint_{n}") for n in range(count)]
    return replace(robot_with(rows), **more)


def prims(stage):
    return {str(prim.GetPath()): prim for prim in stage.Traverse(pxr.Usd.TraverseInstanceProxies())}


def applied(prim):
    return set(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def test_each_face_has_its_unit_normal_outwards(tmp_path):
    stage = stage_of(usd_export(arm(), meshed("part.stl")).files, tmp_path)
    assert complaints(stage) == []
    (mesh,) = (pxr.UsdGeom.Mesh(prim) for prim in prims(stage).values() if prim.IsA(pxr.UsdGeom.Mesh))
    normals = pxr.UsdGeom.PrimvarsAPI(mesh).GetPrimvar("normals")
    assert normals.GetInterpolation() == "uniform"
    values = np.array(normals.ComputeFlattened())
    corners = np.array(mesh.GetPointsAttr().Get())[np.array(mesh.GetFaceVertexIndicesAttr().Get())]
    corners = corners.reshape(-1, 3, 3)
    assert values.shape == (4, 3)
    assert np.abs(np.linalg.norm(values, axis=1) - 1).max() < 2e-5
    for normal, face in zip(values, corners, strict=True):
        assert np.abs((face[1:] - face[0]) @ normal).max() < 5e-5
        assert (face.mean(axis=0) - CORNERS.mean(axis=0)) @ normal > 0


def test_a_face_without_area_has_a_normal_all_the_same(tmp_path):
    geometry = meshed("part.stl")
    thin = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], dtype=float)
    files = {"part.stl": write_stl(Surface(thin, np.array([[0, 1, 2]])))}
    stage = stage_of(usd_export(arm(), replace(geometry, files=files)).files, tmp_path)
    (mesh,) = (prim for prim in prims(stage).values() if prim.IsA(pxr.UsdGeom.Mesh))
    normals = pxr.UsdGeom.PrimvarsAPI(mesh).GetPrimvar("normals").ComputeFlattened()
    assert [tuple(normal) for normal in normals] == [(0, 0, 1)]


def test_collider_that_is_also_seen_is_invisible(tmp_path):
    geometry = meshed("seen.stl", "same.stl", "other.stl")
    moved = write_stl(Surface(CORNERS + 0.1, FACES))
    geometry = replace(geometry, files={**geometry.files, "other.stl": moved})
    stage = stage_of(usd_export(arm(), geometry).files, tmp_path)
    there = prims(stage)
    seen = {
        path.partition("/base/")[2]: pxr.UsdGeom.Imageable(prim).ComputeVisibility()
        for path, prim in there.items()
        if prim.IsA(pxr.UsdGeom.Mesh)
    }
    assert seen == {
        "visuals/visual_1/mesh": "inherited",
        "collisions/collision_1": "invisible",
        "collisions/collision_2": "inherited",
    }
    for number in (1, 2):
        collider = there[f"/robot/base/collisions/collision_{number}"]
        assert collider.HasAPI(pxr.UsdPhysics.CollisionAPI)
        assert pxr.UsdGeom.Imageable(collider).ComputePurpose() == "guide"


def test_mesh_of_two_links_at_a_place_is_visible_on_both(tmp_path):
    """A link may move away from the other: only what the same link shows twice is invisible."""
    own = meshed("base.stl", "part.stl", "hull.stl")
    roles = ("visual", "visual", "collision")
    shapes = [
        replace(own.shapes[0], link=link, file=file, role=role)
        for link in ("base", "link_0")
        for file, role in zip(own.files, roles, strict=True)
    ]
    rows = [joint("revolute", "base", "link_0", [0.0], name="joint_0", place=np.eye(4))]
    stage = stage_of(usd_export(robot_with(rows), replace(own, shapes=tuple(shapes))).files, tmp_path)
    seen = {
        path: pxr.UsdGeom.Imageable(prim).ComputeVisibility()
        for path, prim in prims(stage).items()
        if prim.IsA(pxr.UsdGeom.Mesh)
    }
    assert seen == {
        f"/robot/{link}/{path}": visibility
        for link in ("base", "link_0")
        for path, visibility in (
            ("visuals/visual_1/mesh", "inherited"),
            ("visuals/visual_2/mesh", "invisible"),
            ("collisions/collision_1", "invisible"),
        )
    }


def test_colliders_have_the_schemas_of_newton_and_mujoco(tmp_path):
    round_one = Primitive("sphere", (0.05,), frozen(at(0, 0, 0.1)))
    rows = [joint("revolute", "base", "ball")]
    robot = robot_with(rows, shapes={"ball": (round_one,)})
    shapes = tuple(shape for link in robot.links for shape in primitive_shapes(link))
    mesh = meshed("seen.stl", "part.stl")
    stage = stage_of(usd_export(robot, replace(mesh, shapes=(*mesh.shapes, *shapes))).files, tmp_path)
    both = {"PhysicsCollisionAPI", "NewtonCollisionAPI", "MjcCollisionAPI"}
    hull = applied(stage.GetPrimAtPath("/robot/base/collisions/collision_1"))
    ball = applied(stage.GetPrimAtPath("/robot/ball/collisions/collision_1"))
    assert both | {"PhysicsMeshCollisionAPI", "NewtonMeshCollisionAPI"} <= hull
    assert both <= ball
    assert "NewtonMeshCollisionAPI" not in ball


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


def test_each_actuator_is_what_mujoco_compiles_of_it(tmp_path):
    result = usd_export(arm(7, actuators=ACTUATORS))
    stage = stage_of(result.files, tmp_path)
    model = compiled(result)
    actuators = {
        prim.GetName(): prim for prim in prims(stage).values() if prim.GetTypeName() == "MjcActuator"
    }
    assert [*actuators] == [actuator.name for actuator in ACTUATORS]
    dynamics = ("none", "integrator", "filter", "filterexact")

    def value(prim, name, default):
        attribute = prim.GetAttribute(f"mjc:{name}")
        return attribute.Get() if attribute else default

    for name, prim in actuators.items():
        index = model.actuator(name).id
        (target,) = prim.GetRelationship("mjc:target").GetTargets()
        assert target.name == model.joint(model.actuator_trnid[index, 0]).name
        assert "MjcJointAPI" in applied(stage.GetPrimAtPath(target))
        zeros, unit = [0.0] * 10, [1.0] + [0.0] * 9
        assert list(value(prim, "gainPrm", unit)) == pytest.approx(list(model.actuator_gainprm[index]))
        assert list(value(prim, "biasPrm", zeros)) == pytest.approx(list(model.actuator_biasprm[index]))
        assert list(value(prim, "dynPrm", unit)) == pytest.approx(list(model.actuator_dynprm[index]))
        assert list(value(prim, "gear", unit[:6])) == pytest.approx(list(model.actuator_gear[index]))
        assert value(prim, "dynType", "none") == dynamics[model.actuator_dyntype[index]]
        assert value(prim, "gainType", "fixed") == ("fixed", "affine")[model.actuator_gaintype[index]]
        assert value(prim, "biasType", "none") == ("none", "affine")[model.actuator_biastype[index]]
        for kind, limited, ends in (
            ("ctrl", model.actuator_ctrllimited, model.actuator_ctrlrange),
            ("force", model.actuator_forcelimited, model.actuator_forcerange),
            ("act", model.actuator_actlimited, model.actuator_actrange),
        ):
            said = [value(prim, f"{kind}Range:{end}", None) for end in ("min", "max")]
            assert said == (list(ends[index]) if limited[index] else [None, None]), (name, kind)


def test_an_actuator_that_the_schema_does_not_know_is_left_out(tmp_path):
    own = (("biastype", "user"), ("gaintype", "other"))
    robot = arm(1, actuators=(Actuator("odd", "joint_0", "general", terms=own),))
    stage = stage_of(exported(robot, export={"usd": {}}).files, tmp_path)
    assert not [prim for prim in stage.Traverse() if prim.GetTypeName() == "MjcActuator"]


def test_joints_have_mujocos_numbers_in_radians(tmp_path):
    rows = [joint("revolute", "base", "link_0", [0.4], name="joint_0")]
    (dof,) = rows[0].dofs
    dynamics = Dynamics(damping=0.3, friction=0.2, armature=0.05, effort=4.0)
    rows[0] = replace(rows[0], dofs=(replace(dof, dynamics=dynamics),))
    result = usd_export(robot_with(rows))
    stage = stage_of(result.files, tmp_path)
    prim = stage.GetPrimAtPath("/robot/joints/joint_0")
    model = compiled(result)
    hinge = model.joint("joint_0")
    for name, expected in (
        ("armature", hinge.armature[0]),
        ("damping", hinge.damping[0]),
        ("frictionloss", hinge.frictionloss[0]),
        ("actuatorfrcrange:min", model.jnt_actfrcrange[hinge.id][0]),
        ("actuatorfrcrange:max", model.jnt_actfrcrange[hinge.id][1]),
    ):
        attribute = prim.GetAttribute(f"mjc:{name}")
        assert attribute.Get() == pytest.approx(expected), name
        assert attribute.GetVariability() == pxr.Sdf.VariabilityUniform
        assert attribute.GetTypeName() == "double"


def test_a_joint_that_nothing_drives_has_a_drive_without_force(tmp_path):
    stage = stage_of(usd_export(arm(1)).files, tmp_path)
    drive = pxr.UsdPhysics.DriveAPI(stage.GetPrimAtPath("/robot/joints/joint_0"), "angular")
    assert (drive.GetStiffnessAttr().Get(), drive.GetDampingAttr().Get()) == (0, 0)
    assert 0 < drive.GetMaxForceAttr().Get() < float("inf")


def test_the_metadata_are_the_robots(tmp_path):
    robot, geometry = arm(), meshed("part.stl")
    said = {"author": "Ada", "license": "MIT", "category": "arm", "qcode": "Q42", "date": "2026-01-02"}
    result = usd_export(robot, geometry, **said)
    stage = stage_of(result.files, tmp_path)
    values = dict(stage.GetRootLayer().customLayerData["SimReady_Metadata"])
    bounds = pxr.UsdGeom.BBoxCache(pxr.Usd.TimeCode.Default(), ["default"])
    box = bounds.ComputeWorldBound(stage.GetDefaultPrim()).ComputeAlignedRange()
    assert list(values.pop("asset_extents")) == pytest.approx(list(box.GetSize()), abs=1e-5)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert values.pop("mass") == pytest.approx(model.body_mass.sum())
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(pxr.UsdPhysics.RigidBodyAPI)]
    assert values.pop("rigid_body_count") == len(bodies)
    assert values == {
        "author": "Ada", "asset_name": "robot", "asset_type": "robot", "asset_license": "MIT",
        "category": "arm", "source_file": robot.provenance.document, "usd_date_generated": "2026-01-02",
        "qcode": "Q42",
    }  # fmt: skip


def test_metadata_claim_nothing_that_is_not_said(tmp_path):
    stage = stage_of(usd_export(arm()).files, tmp_path)
    values = stage.GetRootLayer().customLayerData["SimReady_Metadata"]
    for key in ("author", "asset_license", "usd_date_generated"):
        assert values[key] == "unspecified"
    assert list(values["asset_extents"]) == [0, 0, 0]


def test_no_key_of_robot_json_is_one_of_the_metadata(tmp_path):
    """A validator reads `robot.json` beside `robot.usda` as more metadata, and no key may be in both."""
    files = usd_export(arm(), meshed("part.stl")).files
    stage = stage_of(files, tmp_path)
    metadata = dict(stage.GetRootLayer().customLayerData["SimReady_Metadata"])
    assert not metadata.keys() & json.loads(files["robot.json"]).keys()


def test_the_date_is_that_of_the_key_else_of_the_environment():
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
