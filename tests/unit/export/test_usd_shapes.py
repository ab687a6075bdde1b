"""Shapes, frames and cameras of a USD, as an independent reader has them."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.files.stl import write as write_stl
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Exclude, Shape
from linkwright.stages.robot.model.robot import Frame, Primitive, frozen
from tests.support.building import plan_of, solid, write
from tests.support.robots import at, joint, robot_with
from tests.support.touching import ball, box
from tests.support.usd import Usd, complaints, pxr, stage_of
from tests.unit.export.test_usd import losses, read, usd_export
from tests.unit.export.test_usd_simready import FACES

pytestmark = pytest.mark.usefixtures("no_thumbnails")


def shaped():
    kinds = {
        "box": replace(box(0.2, 0.1, 0.3, at(0, 0, 0.1)), colour=(1.0, 0.5, 0.0, 1.0)),
        "ball": ball(0.05),
        "rod": Primitive("cylinder", (0.05, 0.2), frozen(np.eye(4))),
        "pill": Primitive("capsule", (0.05, 0.2), frozen(at(0, 0.1, 0))),
    }
    robot = robot_with(
        [joint("revolute", "base", name) for name in kinds],
        shapes={name: (kind,) for name, kind in kinds.items()},
        frames=[Frame("eye", "pill", frozen(at(0, 0, 0.2)), "Eye")],
    )
    rough = {("ball", "collision"): ContactProperties(friction=(1.2, 0.01, 0.002), condim=6)}
    excludes = (
        Exclude("base", "box", "Adjacent", 0.0),
        Exclude("box", "rod", "User", 0.0),
        Exclude("rod", "pill", "Always", 0.0, ((0, 0),)),
    )
    geometry = solid(robot, self_contact=True, excludes=excludes)
    shapes = (replace(shape, contact=rough.get((shape.link, shape.role))) for shape in geometry.shapes)
    return robot, replace(geometry, shapes=tuple(shapes))


SIZES = {
    "box": {"size": 1, "xformOp:scale": (0.2, 0.1, 0.3), "xformOp:translate": (0, 0, 0.1)},
    "ball": {"radius": 0.05},
    "rod": {"radius": 0.05, "height": 0.2, "axis": "Z"},
    "pill": {"radius": 0.05, "height": 0.2, "axis": "Z", "xformOp:translate": (0, 0.1, 0)},
}


def material_of(prim, purpose=""):
    material, _ = pxr.UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(*([purpose] if purpose else []))
    return material


def test_shapes_collide_as_they_are_and_look_as_they_do(tmp_path):
    robot, geometry = shaped()
    usd = read(tmp_path, robot, geometry)
    get, path = usd.stage.GetPrimAtPath, str(usd.root.GetPath())
    colliders = {name: get(f"{path}/{name}/collisions/collision_1") for name in SIZES}
    for name, sizes in SIZES.items():
        assert {key: colliders[name].GetAttribute(key).Get() for key in sizes} == sizes
    assert pxr.UsdGeom.Imageable(colliders["box"]).ComputePurpose() == "guide"
    rough = material_of(colliders["ball"], "physics").GetPrim()
    names = ("physics:staticFriction", "physics:dynamicFriction")
    names += ("newton:torsionalFriction", "newton:rollingFriction")
    values = [rough.GetAttribute(name).Get() for name in names]
    assert values == pytest.approx([1.2, 1.2, 0.01, 0.002])
    seen = material_of(get(f"{path}/box/visuals/visual_1"))
    colour = seen.ComputeSurfaceSource()[0].GetInput("diffuseColor").Get()
    # sRGB's 0.5 is 0.214 of the light.
    assert colour == pytest.approx((1.0, 0.21404114, 0.0))
    pairs = {
        str(prim.GetPath()).removeprefix(path): [str(to).removeprefix(path) for to in rel.GetTargets()]
        for prim in usd.stage.Traverse()
        if (rel := prim.GetRelationship("physics:filteredPairs"))
    }
    assert pairs == {"/box": ["/rod"], "/rod/collisions/collision_1": ["/pill/collisions/collision_1"]}
    for name in ("newton:selfCollisionEnabled", "physxArticulation:enabledSelfCollisions"):
        assert usd.roots[0].GetAttribute(name).Get() is True
    assert losses(robot, geometry)["I-USD-CONTACT"].endswith("ball: condim")


@pytest.mark.parametrize(
    ("pattern", "new", "check"),
    [
        (r"(prepend )?rel physics:filteredPairs = </robot/pill/collisions/collision_1>", "", "model"),
        (r"physics:filteredPairs = </robot/pill/", "physics:filteredPairs = </robot/ball/", "model"),
        (r'axis = "Z"', 'axis = "X"', "shapes"),
        (r'(Sphere "collision_1".*?)(uniform token\[\] xformOpOrder = [^\]]*)\]',
         r'\1double3 xformOp:scale = (1, 1, 2)\n\2, "xformOp:scale"]', "shapes"),
    ],
)  # fmt: skip
def test_pair_axis_or_scale_that_differs_is_found(pattern, new, check, tmp_path):
    from linkwright.stages.validate.read.usd import check_file

    robot, geometry = shaped()
    written = write(robot, tmp_path, plan_of(export={"usd": {}}), geometry).written
    path = tmp_path / "robot.usda"
    assert all(result.passed for result in check_file(path, written, quick=False))
    text, count = re.subn(pattern, new, path.read_text(), count=1, flags=re.DOTALL)
    assert count
    path.write_text(text)
    wrong = [result.name for result in check_file(path, written, quick=False) if not result.passed]
    assert f"robot.usda: {check}" in wrong


def test_frames_and_cameras_are_where_they_were(tmp_path):
    robot, geometry = shaped()
    look = {"type": "camera", "frame": "eye", "fovy": 60, "resolution": [320, 240]}
    sensors = {"look": look, "imu": {"type": "imu", "frame": "pill"}}
    usd = read(tmp_path, robot, geometry, sensors=sensors)
    pill = f"{usd.root.GetPath()}/pill"
    frame = usd.stage.GetPrimAtPath(f"{pill}/eye")
    eye = np.array(pxr.UsdGeom.XformCache().GetLocalToWorldTransform(frame)).T
    assert np.abs(eye - usd.stands["pill"] @ at(0, 0, 0.2)).max() < 1e-9
    camera = pxr.UsdGeom.Camera(usd.stage.GetPrimAtPath(f"{pill}/look")).GetCamera(0)
    assert camera.GetFieldOfView(camera.FOVVertical) == pytest.approx(60, abs=1e-4)
    assert camera.aspectRatio == pytest.approx(320 / 240)
    looks = camera.frustum.ComputeViewDirection(), camera.frustum.ComputeUpVector()
    # Ours looks along z of its frame, with y down.
    assert np.abs(np.array(looks) - [eye[:3, 2], -eye[:3, 1]]).max() < 1e-6
    assert "imu" in losses(robot, geometry, sensors=sensors)["I-USD-SENSOR"]


@pytest.mark.parametrize("name", ["2 arms", "räder@home", "def", "world"])
def test_robot_of_any_name_is_a_stage(name, tmp_path):
    robot, geometry = shaped()
    robot = replace(robot, name=name)
    stage = stage_of(usd_export(robot, with_mesh(geometry)).files, tmp_path, name)
    assert complaints(stage) == []
    usd = Usd(stage)
    mesh = stage.GetPrimAtPath(f"{usd.root.GetPath()}/base/collisions/collision_1")
    assert len(mesh.GetAttribute("points").Get()) == 4


def with_mesh(geometry):
    """With a tetrahedron on the base, seen twice."""
    seen = Shape("base", "visual", "base.stl", (1.0, 0.0, 0.0, 0.5), 4, 4, 0.02, 1e-4)
    hit = replace(seen, role="collision", colour=None)
    files = {"base.stl": write_stl(Surface(0.1 * np.eye(4, 3, -1), FACES))}
    return replace(geometry, shapes=(hit, seen, seen, *geometry.shapes), files=files)


@pytest.mark.parametrize("encoding", ["binary", "text"])
def test_mesh_is_there_once_and_seen_as_an_instance(encoding, tmp_path):
    robot, geometry = shaped()
    keys = {"export": {"usd": {"geometry": encoding}, "urdf": {}}}
    files = usd_export(robot, with_mesh(geometry), **keys).files
    assert files["robot_meshes.usd"].startswith(b"PXR-USDC" if encoding == "binary" else b"#usda 1.0")
    stage = stage_of(files, tmp_path)
    assert complaints(stage) == []
    path = f"{stage.GetDefaultPrim().GetPath()}/base"
    first, second = (stage.GetPrimAtPath(f"{path}/visuals/visual_{number}") for number in (1, 2))
    assert first.IsInstance()
    assert first.GetPrototype() == second.GetPrototype()
    mesh = stage.GetPrimAtPath(f"{path}/collisions/collision_1")
    assert pxr.UsdPhysics.MeshCollisionAPI(mesh).GetApproximationAttr().Get() == "convexHull"
    points = np.array(mesh.GetAttribute("points").Get())
    triangles = points[np.array(mesh.GetAttribute("faceVertexIndices").Get()).reshape(-1, 3)]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    outwards = triangles.mean(axis=1) - points.mean(axis=0)
    assert (np.einsum("ij,ij->i", normals, outwards) > 0).all()


def test_image_is_the_texture_of_shapes_with_coordinates(tmp_path):
    robot, geometry = shaped()
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    seen = Shape("base", "visual", "label.obj", (1.0, 1.0, 1.0, 1.0), 3, 1, 0.5, 0.0, texture="label.png")
    files = {"label.obj": text.encode(), "label.png": b"image"}
    geometry = replace(geometry, shapes=(seen, *geometry.shapes), files=files)
    stage = stage_of(usd_export(robot, geometry).files, tmp_path)
    assert complaints(stage) == []
    path = f"{stage.GetDefaultPrim().GetPath()}/base/visuals/visual_1"
    instance = stage.GetPrimAtPath(path)
    (mesh,) = instance.GetPrototype().GetChildren()
    primvar = pxr.UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    assert primvar.GetInterpolation() == "faceVarying"
    assert np.array(primvar.Get()).tolist() == [[0, 0], [1, 0], [0, 1]]
    image = stage.GetPrimAtPath(f"{material_of(instance).GetPath()}/image").GetAttribute("inputs:file").Get()
    assert Path(image.resolvedPath).name == "label.png"
