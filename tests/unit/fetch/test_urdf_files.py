"""A robot's file and its meshes as a bundle: text, packages, places, formats, and what is never lost."""

import io
import json
import os
import re
import subprocess
import sys
from hashlib import sha256

import numpy as np
import pytest
import trimesh

from linkwright.stages.fetch import pinned, preflight
from linkwright.stages.fetch.bundle import archive as packing
from linkwright.stages.fetch.urdf.gather import gather
from linkwright.stages.fetch.urdf.section import UrdfSourceSection
from linkwright.stages.fetch.urdf.source import UrdfSource
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.robot.bundle import FileBundle
from linkwright.stages.robot.errors import ConfigError, SourceError
from linkwright.stages.robot.model.geometry import NEUTRAL
from tests.support.building import plan_of
from tests.support.places import PROJECT
from tests.support.textures import put

SIZE = (0.1, 0.2, 0.4)


def block(kind="stl", **how):
    """A box of SIZE from the origin, as a file."""
    mesh = trimesh.creation.box(bounds=[(0, 0, 0), SIZE])
    data = mesh.export(file_type=kind, **how)
    return data if isinstance(data, bytes) else data.encode()


def urdf(*names, more="", inside=""):
    shapes = "".join(
        f'<visual><geometry><mesh filename="{name}"{more}/></geometry>{inside}</visual>' for name in names
    )
    return f'<robot name="r"><link name="a">{shapes}</link></robot>'.encode()


def gathered(path, environ=None, **keys):
    return gather(UrdfSourceSection(path=str(path), **keys), environ or {})


def bodies(bundle):
    meshes = [digest for request, digest in bundle.requests.items() if request.startswith("mesh/")]
    return {
        name: body for digest in meshes for name, body in body_arrays.decode(bundle.blobs[digest]).items()
    }


def only_body(path, **keys):
    (body,) = bodies(gathered(path, **keys)[0]).values()
    return body


def volume(body):
    return float(trimesh.Trimesh(body.points, body.triangles, process=False).volume)


def refused(path, environ=None, **keys):
    with pytest.raises(SourceError) as caught:
        gathered(path, environ, **keys)
    assert str(path.parent) not in str(caught.value)
    return caught.value


# What a bundle is.


def test_a_bundle_holds_each_mesh_once_and_no_path(tmp_path):
    absolute = tmp_path / "far" / "c.stl"
    here = tmp_path / "here"
    put(here, **{"r.urdf": urdf("a.stl", "a.stl", f"file://{here}/b.stl", str(absolute))})
    put(here, **{"a.stl": block(), "b.stl": block(), "../far/c.stl": block()})
    bundle, reports = gathered(here / "r.urdf", bad_inertia="project")
    assert reports == ()
    assert (bundle.kind, bundle.root["document"]) == ("urdf", "r.urdf")
    assert bundle.options == {"bad_inertia": "project"}
    assert [request for request in bundle.requests if not request.startswith("mesh/")] == ["robot.urdf"]
    assert len(bundle.requests) == 4
    assert bundle.definition == bundle.requests["robot.urdf"]
    assert all(sha256(body).hexdigest() == digest for digest, body in bundle.blobs.items())
    assert not [body for body in bundle.blobs.values() if str(tmp_path).encode() in body]
    assert b'"b.stl"' in bundle.blobs[bundle.definition]
    assert b'"elsewhere/1/c.stl"' in bundle.blobs[bundle.definition]


def test_a_bundle_is_known_by_the_content_of_its_files(tmp_path):
    def made(folder, mesh, mtl):
        obj = b"mtllib m.mtl\nusemtl x\n" + block("obj", include_normals=False)
        files = {"r.urdf": urdf("a.obj", "b.stl"), "a.obj": obj, "b.stl": mesh, "m.mtl": mtl}
        put(tmp_path / folder, **files)
        plan = plan_of(source={"kind": "urdf", "path": str(tmp_path / folder / "r.urdf")})
        identities.append(json.dumps(pinned(plan, {})))
        return gather(plan.source, {})[0]

    identities = []
    red = b"newmtl x\nKd 1 0 0\n"
    first, same = made("one", block(), red), made("two", block(), red)
    other, blue = made("three", block() + b"more", red), made("four", block(), b"newmtl x\nKd 0 0 1\n")
    assert (first.root, first.requests) == (same.root, same.requests)
    assert identities[0] == identities[1]
    assert len(set(identities)) == 3
    assert len({bundle.root["microversion"] for bundle in (first, other, blue)}) == 3
    assert first.requests == other.requests
    assert first.requests != blue.requests


def test_a_packed_bundle_is_read_back_unless_it_is_harmed(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("a.stl"), "a.stl": block()})
    bundle, _ = gathered(tmp_path / "r.urdf", bad_inertia="recompute")
    recording = packing.read(packing.pack(bundle), "x.zip")
    assert UrdfSource.replay(recording, "x.zip") == bundle
    bad = sha256(b"no triangles").hexdigest()
    requests, blobs = {**bundle.requests, "mesh/x": bad}, {**bundle.blobs, bad: b"no triangles"}
    harmed = FileBundle("urdf", bundle.root, bundle.definition, requests, blobs)
    with pytest.raises(SourceError, match="compact form"):
        UrdfSource.replay(packing.read(packing.pack(harmed), "x.zip"), "x.zip")


# Text.


@pytest.mark.parametrize(
    "encode",
    [
        lambda text: text.encode("utf-16"),
        lambda text: b"\xef\xbb\xbf" + text.encode(),
        lambda text: b"<?xml version='1.0' encoding='ISO-8859-1'?>" + text.encode("latin-1"),
    ],
)
def test_text_in_any_encoding_is_read(tmp_path, encode):
    put(tmp_path, **{"r.urdf": encode(urdf("Größe.stl").decode()), "Größe.stl": block()})
    assert volume(only_body(tmp_path / "r.urdf")) == pytest.approx(0.008)


@pytest.mark.parametrize("unit", ["nan", "inf", "0", "-1"])
def test_a_dae_with_an_impossible_unit_is_damaged(tmp_path, unit):
    text = re.sub(r"<unit[^>]*/>", "", block("dae").decode())
    data = text.replace("<asset>", f'<asset><unit name="u" meter="{unit}"/>', 1).encode()
    put(tmp_path, **{"r.urdf": urdf("m.dae"), "m.dae": data})
    (problem,) = refused(tmp_path / "r.urdf").problems
    assert (problem.code, "unit" in problem.message) == ("E-MESH-READ", True)


def test_an_unknown_encoding_and_a_long_package_are_one_message(tmp_path):
    put(tmp_path, **{"r.urdf": b'<?xml version="1.0" encoding="undefined"?><robot name="r"/>'})
    assert "it is not text" in refused(tmp_path / "r.urdf").message
    put(tmp_path, **{"r.urdf": urdf(f"package://{'p' * 300}/a.stl")})
    assert [problem.code for problem in refused(tmp_path / "r.urdf").problems] == ["E-MESH-MISSING"]


def test_problems_of_text_and_meshes_are_reported_together(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("a.stl", "b.stl", inside="<origin xyz='x'/>"), "b.stl": b""})
    problems = [(problem.code, problem.message) for problem in refused(tmp_path / "r.urdf").problems]
    assert [code for code, _ in problems] == ["E-URDF-NUMBER"] * 2 + ["E-MESH-MISSING", "E-MESH-READ"]
    assert problems[3][1] == "mesh b.stl: it is empty"
    put(tmp_path, **{"r.urdf": urdf("a.stl", "b.stl", "c.stl"), "c.stl": block()})
    bundle, reports = gathered(tmp_path / "r.urdf", missing_meshes="skip")
    assert [problem.code for problem in reports] == ["W-NO-MESH"] * 2
    assert len(bundle.requests) == 2
    # A mesh in a comment is none, and lines keep their numbers.
    put(tmp_path, **{"r.urdf": b'<robot name="r"><!--\n<mesh filename="gone.stl"/>\n-->\n<link/></robot>'})
    assert "line 4" in str(refused(tmp_path / "r.urdf"))


# Places.

ROS = "ROS_PACKAGE_PATH"
PLACES = {
    "given": ("any", {}),
    "ros": ("far/p", {ROS: os.pathsep.join(["FAR/none", "FAR"])}),
    "ros itself": ("far/p", {ROS: "FAR/p"}),
    "ros called": ("far/x", {ROS: "FAR"}),
    "deep": ("far/x/y", {ROS: "FAR"}),
    "ament": ("far/share/p", {"AMENT_PREFIX_PATH": "FAR"}),
    "above": ("p", {}),
    "beside": ("p", {}),
    "model": ("far/p", {ROS: "FAR"}),
}
"""Where a package's folder is, and the environment that leads to it."""


def test_names_are_found_where_they_say(tmp_path):
    names = ("m/a.stl", "package:///m/b.stl", "package://own/m/c.stl", "m%20n/d.stl", "m\\e.stl")
    put(
        tmp_path / "folder",
        **{"package.xml": b"<package><name>own</name></package>", "urdf/r.urdf": urdf(*names)},
    )
    put(tmp_path / "folder", **{"m/c.stl": block(), "urdf/m/a.stl": block(), "urdf/m/b.stl": block()})
    put(tmp_path / "folder", **{"urdf/m n/d.stl": block(), "urdf/m/e.stl": block()})
    bundle, reports = gathered(tmp_path / "folder" / "urdf" / "r.urdf")
    assert len(bundle.requests) == 6
    assert reports == ()


@pytest.mark.parametrize("how", PLACES)
def test_packages_are_found_everywhere_that_ros_has_them(tmp_path, how):
    place, environ = PLACES[how]
    folder, far = tmp_path / place, str(tmp_path / "far")
    environ = {name: value.replace("FAR", far) for name, value in environ.items()}
    keys = {"packages": {"p": str(folder)}} if how == "given" else {}
    if how in ("ros called", "deep"):
        put(folder, **{"package.xml": b"<package>\n<name> p </name></package>"})
    robot = folder / "urdf" / "r.urdf" if how == "above" else tmp_path / "here" / "r.urdf"
    put(robot.parent, **{robot.name: urdf(f"{'model' if how == 'model' else 'package'}://p/a.stl")})
    put(folder, **{"a.stl": block()})
    bundle, reports = gathered(robot, environ, **keys)
    assert (len(bundle.requests), reports) == (2, ())


def test_the_folder_that_mujocos_extension_names_is_looked_in(tmp_path):
    text = urdf("x/y/a.stl").replace(b'"r">', b'"r"><mujoco><compiler meshdir="../parts/"/></mujoco>')
    put(tmp_path, **{"robots/r.urdf": text, "parts/a.stl": block()})
    bundle, reports = gathered(tmp_path / "robots" / "r.urdf")
    assert (len(bundle.requests), reports) == (2, ())


def test_moved_files_are_found_by_a_unique_name(tmp_path):
    names = ("package://gone/meshes/a.stl", "meshes/B.STL", "visual/c.stl", "/home/nobody/d.stl")
    put(tmp_path, **{"urdf/r.urdf": urdf(*names), "meshes/a.stl": block(), "other/b.stl": block()})
    put(tmp_path, **{"m/visual/c.stl": block(), "m/collision/c.stl": block("ply"), "d.stl": block()})
    bundle, reports = gathered(tmp_path / "urdf" / "r.urdf")
    assert len(bundle.requests) == 5
    assert {problem.code for problem in reports} == {"I-MESH-FOUND"}
    assert [problem.message for problem in reports] == [
        "a.stl: not found in package://gone/meshes/, used from ../meshes/",
        "meshes/B.STL was not found; ../other/b.stl is used instead",
        "c.stl: not found in visual/, used from ../m/visual/",
        "d.stl: not found in elsewhere/1/, used from ../",
    ]


def test_an_ambiguous_or_remote_mesh_is_not_read(tmp_path):
    names = urdf("x/a.stl", "https://example.com/b.stl")
    put(tmp_path, **{"r.urdf": names, "m/a.stl": block(), "n/a.stl": block(), "b.stl": block()})
    first, second = (problem.message for problem in refused(tmp_path / "r.urdf").problems)
    several = "there is no such file, and several files have that name: m/a.stl, n/a.stl"
    assert first == f"mesh x/a.stl: {several}"
    assert "not downloaded" in second


# Formats.


def coloured(kind):
    mesh = trimesh.creation.box(bounds=[(0, 0, 0), SIZE])
    mesh.visual.face_colors = [[255, 0, 0, 255]] * 6 + [[0, 0, 255, 255]] * 6
    data = mesh.export(file_type=kind)
    return data if isinstance(data, bytes) else data.encode()


@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "obj", "dae", "glb", "ply", "gltf"])
def test_every_format_gives_the_same_solid(tmp_path, kind):
    name = f"a.{kind.partition('_')[0].upper()}"
    files = {name: block(kind)} if kind != "gltf" else {}
    if not files:  # with its buffer beside it
        scene = trimesh.Scene(trimesh.creation.box(bounds=[(0, 0, 0), SIZE]))
        files, name = trimesh.exchange.gltf.export_gltf(scene), "model.gltf"
    put(tmp_path, **{"r.urdf": urdf(name), **files})
    body = only_body(tmp_path / "r.urdf")
    assert volume(body) == pytest.approx(0.008, rel=1e-6)
    np.testing.assert_allclose([body.points.min(0), body.points.max(0)], [(0, 0, 0), SIZE], atol=1e-7)


def test_a_binary_stl_is_read_as_trimesh_reads_it_but_without_it(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    faces = np.concatenate([ball.faces, ball.faces[:3], [[0, 0, 1]]])
    data = trimesh.Trimesh(ball.vertices, faces, process=False).export(file_type="stl")
    put(tmp_path, **{"r.urdf": urdf("a.stl", more=' scale="-1 2 1"'), "a.stl": data + b"more"})
    body = only_body(tmp_path / "r.urdf")
    read = trimesh.load_mesh(io.BytesIO(data), file_type="stl", process=False)
    assert (body.points[body.triangles] == (read.triangles * [-1, 2, 1])[:, ::-1]).all()
    assert len(body.points) == len(ball.vertices)
    code = f"""import sys
from pathlib import Path
from linkwright.stages.fetch.urdf.meshes.companions import Companions
from linkwright.stages.fetch.urdf.meshes.mesh_file import read
read(Path({str(tmp_path / "a.stl")!r}).read_bytes(), "a.stl", Companions())
print("trimesh" in sys.modules)"""
    assert subprocess.check_output([sys.executable, "-c", code], cwd=PROJECT, text=True).strip() == "False"


def test_a_mirroring_scale_keeps_the_outside_outside(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("a.stl", more=' scale="2 -1 0.5"'), "a.stl": block()})
    body = only_body(tmp_path / "r.urdf")
    assert volume(body) == pytest.approx(0.008, rel=1e-6)
    np.testing.assert_allclose(
        [body.points.min(0), body.points.max(0)], [(0, -0.2, 0), (0.2, 0, 0.2)], atol=1e-7
    )


def test_colours_are_the_files_unless_the_robot_has_some(tmp_path):
    blue = "<material><color rgba='0 0 0.5 1'/></material>"
    put(tmp_path, **{"r.urdf": urdf("a.ply"), "s.urdf": urdf("a.ply", inside=blue), "a.ply": coloured("ply")})
    body = only_body(tmp_path / "r.urdf")
    assert body.palette == ((0, 0, 1, 1), (1, 0, 0, 1))
    assert sorted(np.bincount(body.colours)) == [6, 6]
    assert only_body(tmp_path / "s.urdf").palette == ((0, 0, 0.5, 1),)
    shaded = trimesh.creation.icosphere(subdivisions=3)
    shade = np.linspace(0, 255, len(shaded.faces)).astype(int)
    shaded.visual.face_colors = np.stack([shade, shade[::-1], shade, np.full_like(shade, 255)], axis=1)
    put(tmp_path, **{"a.ply": shaded.export(file_type="ply")})
    assert 1 < len(only_body(tmp_path / "r.urdf").palette) <= 16


def test_materials_of_an_obj_are_its_colours(tmp_path):
    lines = ["mtllib m.mtl", "v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1", "usemtl red", "f 1 3 2", "f 1 2 4"]
    obj = "\n".join([*lines, "usemtl blue", "f 1 4 3", "f 2 3 4"])
    mtl = b"# caf\xe9\nnewmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\nd 0.2\nmap_Kd ../../secret.png\n"
    put(tmp_path, **{"r.urdf": urdf("a.obj"), "a.obj": obj.encode(), "m.mtl": mtl})
    body = only_body(tmp_path / "r.urdf")
    assert {tuple(colour[:3]) for colour in body.palette} == {(1, 0, 0), (0, 0, 1)}
    assert volume(body) == pytest.approx(1 / 6)
    (lost,) = gathered(tmp_path / "r.urdf")[1]
    assert lost.code == "W-TEXTURE"
    assert lost.message == (
        "the texture secret.png of a.obj is left out: it is outside of the robot's folders"
    )


def test_images_of_a_gltf_that_are_no_colours_are_lost(tmp_path):
    file = json.loads(trimesh.creation.box().export(file_type="gltf")["model.gltf"])
    buffers = trimesh.creation.box().export(file_type="gltf")
    data = {"uri": "data:image/png;base64,AA==", "name": "logo"}
    file["images"] = [{"uri": "wood.png"}, data, {"bufferView": 0}]
    files = {name: data for name, data in buffers.items() if name != "model.gltf"}
    put(tmp_path, **{"r.urdf": urdf("a.gltf"), "a.gltf": json.dumps(file).encode()}, **files)
    (lost,) = gathered(tmp_path / "r.urdf")[1]
    assert lost.code == "I-URDF-TEXTURE"
    assert "a.gltf (an image in it, logo, wood.png)" in lost.message


DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Y_UP</up_axis></asset>
<library_images><image id="i"><init_from>gone.png</init_from></image></library_images>
<library_effects>
 <effect id="whole"><profile_COMMON><technique sid="c">
  <phong><diffuse><color>1 0 0 1</color></diffuse></phong></technique></profile_COMMON></effect>
 <effect id="pictured"><profile_COMMON>
  <newparam sid="s"><sampler2D><source>nowhere</source></sampler2D></newparam>
  <technique sid="c"><phong><diffuse><texture texture="i" texcoord="u"/></diffuse></phong></technique>
  </profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#whole"/></material>
 <material id="n"><instance_effect url="#pictured"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
 <source id="p"><float_array id="f" count="12">0 0 0 1000 0 0 0 1000 0 0 0 1000</float_array>
  <technique_common><accessor source="#f" count="4" stride="3"><param name="X" type="float"/>
  <param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
 <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
 <triangles count="2" material="one"><input semantic="VERTEX" source="#v" offset="0"/>
  <p>0 2 1 0 1 3</p></triangles>
 <triangles count="1" material="two"><input semantic="VERTEX" source="#v" offset="0"/>
  <p>0 3 2</p></triangles>
 <triangles count="1" material="three"><input semantic="VERTEX" source="#v" offset="0"/>
  <p>1 2 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><translate>0 0 500</translate><instance_geometry url="#g">
 <bind_material><technique_common><instance_material symbol="one" target="#m"/>
 <instance_material symbol="two" target="#n"/><instance_material symbol="three" target="#lost"/>
 </technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def test_a_dae_has_its_unit_nodes_and_all_its_shapes(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("a.dae"), "a.dae": DAE.encode()})
    body = only_body(tmp_path / "r.urdf")
    assert volume(body) == pytest.approx(1 / 6)
    np.testing.assert_allclose(
        [body.points.min(0), body.points.max(0)], [(0, 0, 0.5), (1, 1, 1.5)], atol=1e-12
    )
    assert body.palette == (NEUTRAL, (1, 0, 0, 1), (1, 1, 1, 1))
    lost = DAE.replace("<node>", '<node><instance_geometry url="#lost"/></node><node>')
    put(tmp_path, **{"a.dae": lost.encode()})
    (problem,) = refused(tmp_path / "r.urdf").problems
    assert problem.code == "E-MESH-READ"


# What is known beforehand.


def test_a_wrong_package_is_known_before_any_work(tmp_path):
    put(tmp_path, **{"r.urdf": urdf()})
    source = {"kind": "urdf", "path": str(tmp_path / "r.urdf"), "packages": {"p": "gone"}}
    with pytest.raises(ConfigError) as caught:
        preflight(plan_of(source=source), {})
    assert caught.value.where == "source.packages.p"
