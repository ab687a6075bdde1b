"""A robot's file and its meshes as a bundle: text, packages, places, formats, and what is never lost."""

import io
import json
import os
import struct
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
import trimesh

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.fetch import pinned, preflight
from linkwright.stages.fetch.bundle import archive as packing
from linkwright.stages.fetch.urdf.gather import gather
from linkwright.stages.fetch.urdf.section import UrdfSourceSection
from linkwright.stages.fetch.urdf.source import UrdfSource
from linkwright.stages.formats import triangles
from linkwright.stages.robot.bundle import Bundle, FileBundle
from linkwright.stages.robot.errors import ConfigError, Diagnostic, SourceError
from linkwright.stages.robot.model.geometry import NEUTRAL
from tests.support.places import PROJECT

SIZE = (0.1, 0.2, 0.4)


def block(kind: str = "stl", **how: object) -> bytes:
    """A box of SIZE from the origin, as a file."""
    mesh = trimesh.creation.box(bounds=[(0, 0, 0), SIZE])
    data = mesh.export(file_type=kind, **how)
    return data if isinstance(data, bytes) else data.encode()


def put(folder: Path, **files: bytes) -> None:
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def urdf(*names: str, more: str = "", inside: str = "") -> bytes:
    shapes = "".join(
        f'<visual><geometry><mesh filename="{name}"{more}/></geometry>{inside}</visual>' for name in names
    )
    return f'<robot name="r"><link name="a">{shapes}</link></robot>'.encode()


def gathered(
    path: Path, environ: dict[str, str] | None = None, **keys: object
) -> tuple[Bundle, tuple[Diagnostic, ...]]:
    return gather(UrdfSourceSection(path=str(path), **keys), environ or {})


def bodies(bundle: Bundle) -> dict[str, triangles.Body]:
    found = {}
    for request, digest in bundle.requests.items():
        if request.startswith("mesh/"):
            found |= triangles.decode(bundle.blobs[digest])
    return found


def only_body(path: Path, **keys: object) -> triangles.Body:
    (body,) = bodies(gathered(path, **keys)[0]).values()
    return body


def volume(body: triangles.Body) -> float:
    return float(trimesh.Trimesh(body.points, body.triangles, process=False).volume)


def refused(path: Path, environ: dict[str, str] | None = None, **keys: object) -> SourceError:
    with pytest.raises(SourceError) as caught:
        gathered(path, environ, **keys)
    assert str(path.parent) not in str(caught.value)
    return caught.value


# What a bundle is.


def test_a_bundle_holds_the_text_and_each_mesh_once_and_says_nothing_of_this_computer(tmp_path):
    absolute = tmp_path / "far" / "c.stl"
    here = tmp_path / "here"
    put(here, **{"r.urdf": urdf("a.stl", "a.stl", f"file://{here}/b.stl", str(absolute))})
    put(here, **{"a.stl": block(), "b.stl": block(), "../far/c.stl": block()})
    bundle, found = gathered(here / "r.urdf", bad_inertia="project")
    assert found == ()
    assert (bundle.kind, bundle.root["document"], bundle.options) == (
        "urdf",
        "r.urdf",
        {"bad_inertia": "project"},
    )
    assert [request for request in bundle.requests if not request.startswith("mesh/")] == ["robot.urdf"]
    assert len(bundle.requests) == 4
    assert bundle.definition == bundle.requests["robot.urdf"]
    assert all(sha256(body).hexdigest() == digest for digest, body in bundle.blobs.items())
    assert not [body for body in bundle.blobs.values() if str(tmp_path).encode() in body]
    assert b'"b.stl"' in bundle.blobs[bundle.definition]
    assert b'"elsewhere/1/c.stl"' in bundle.blobs[bundle.definition]


def test_the_same_files_elsewhere_are_the_same_bundle_and_any_change_is_another(tmp_path):
    def made(folder: str, mesh: bytes, mtl: bytes) -> Bundle:
        obj = b"mtllib m.mtl\nusemtl x\n" + block("obj", include_normals=False)
        put(
            tmp_path / folder, **{"r.urdf": urdf("a.obj", "b.stl"), "a.obj": obj, "b.stl": mesh, "m.mtl": mtl}
        )
        keys = UrdfSourceSection(path=str(tmp_path / folder / "r.urdf"))
        plan = Plan.model_validate({"name": "r", "source": keys})
        bundle, _ = gather(keys, {})
        identities.append(json.dumps(pinned(plan, {})))
        return bundle

    identities: list[str] = []
    red = b"newmtl x\nKd 1 0 0\n"
    one, same = made("one", block(), red), made("two", block(), red)
    other, blue = made("three", block() + b"more", red), made("four", block(), b"newmtl x\nKd 0 0 1\n")
    assert (one.root, one.requests) == (same.root, same.requests)
    assert identities[0] == identities[1]
    assert len(set(identities)) == 3
    assert len({bundle.root["microversion"] for bundle in (one, other, blue)}) == 3
    assert one.requests == other.requests
    assert one.requests != blue.requests


def test_a_packed_bundle_is_read_back_as_it_was(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("a.stl"), "a.stl": block()})
    bundle, _ = gathered(tmp_path / "r.urdf", bad_inertia="recompute")
    recording = packing.read(packing.pack(bundle), "x.zip")
    assert UrdfSource.replay(recording, "x.zip") == bundle


def test_a_packed_bundle_with_a_mesh_that_is_none_is_refused(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("a.stl"), "a.stl": block()})
    bundle, _ = gathered(tmp_path / "r.urdf")
    bad = sha256(b"no triangles").hexdigest()
    requests = {**bundle.requests, "mesh/x": bad}
    blobs = {**bundle.blobs, bad: b"no triangles"}
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


def test_a_mesh_in_a_comment_is_no_mesh_and_lines_keep_their_numbers(tmp_path):
    put(tmp_path, **{"r.urdf": b'<robot name="r"><!--\n<mesh filename="gone.stl"/>\n-->\n<link/></robot>'})
    assert "line 4" in str(refused(tmp_path / "r.urdf"))


def test_problems_of_the_text_and_of_meshes_are_reported_together(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("a.stl", "b.stl", inside="<origin xyz='x'/>"), "b.stl": b""})
    told = [(one.code, one.message) for one in refused(tmp_path / "r.urdf").problems]
    assert [code for code, _ in told] == ["E-URDF-NUMBER"] * 2 + ["E-MESH-MISSING", "E-MESH-READ"]
    assert told[3][1] == "mesh b.stl: it is empty"


def test_missing_and_broken_meshes_may_be_left_out(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("a.stl", "b.stl", "c.stl"), "b.stl": b"", "c.stl": block()})
    bundle, found = gathered(tmp_path / "r.urdf", missing_meshes="skip")
    assert [one.code for one in found] == ["W-NO-MESH"] * 2
    assert len(bundle.requests) == 2


# Places.

PLACES = ("given", "ros", "ros itself", "ros called", "deep", "ament", "above", "beside", "model")


def test_names_are_found_where_they_say(tmp_path):
    names = ("m/a.stl", "package:///m/b.stl", "package://own/m/c.stl", "m%20n/d.stl", "m\\e.stl")
    put(
        tmp_path / "folder",
        **{"package.xml": b"<package><name>own</name></package>", "urdf/r.urdf": urdf(*names)},
    )
    put(tmp_path / "folder", **{"m/c.stl": block(), "urdf/m/a.stl": block(), "urdf/m/b.stl": block()})
    put(tmp_path / "folder", **{"urdf/m n/d.stl": block(), "urdf/m/e.stl": block()})
    bundle, found = gathered(tmp_path / "folder" / "urdf" / "r.urdf")
    assert len(bundle.requests) == 6
    assert found == ()


@pytest.mark.parametrize("how", PLACES)
def test_packages_are_found_everywhere_that_ros_has_them(tmp_path, how):
    folder, keys, environ = tmp_path / "far" / "p", {}, {}
    name = f"{'model' if how == 'model' else 'package'}://p/a.stl"
    robot = tmp_path / "here" / "r.urdf"
    if how == "given":
        folder = tmp_path / "any"
        keys["packages"] = {"p": str(folder)}
    elif how in ("ros", "model"):
        environ["ROS_PACKAGE_PATH"] = os.pathsep.join([str(tmp_path / "none"), str(tmp_path / "far")])
    elif how == "ros itself":
        environ["ROS_PACKAGE_PATH"] = str(folder)
    elif how in ("ros called", "deep"):
        folder = tmp_path / "far" / ("x/y" if how == "deep" else "x")
        put(folder, **{"package.xml": b"<package>\n<name> p </name></package>"})
        environ["ROS_PACKAGE_PATH"] = str(tmp_path / "far")
    elif how == "ament":
        folder = tmp_path / "far" / "share" / "p"
        environ["AMENT_PREFIX_PATH"] = str(tmp_path / "far")
    elif how == "above":
        folder = tmp_path / "p"
        robot = folder / "urdf" / "r.urdf"
    else:
        folder = tmp_path / "p"
    put(robot.parent, **{robot.name: urdf(name)})
    put(folder, **{"a.stl": block()})
    bundle, found = gathered(robot, environ, **keys)
    assert len(bundle.requests) == 2
    assert found == ()


def test_the_folder_that_mujocos_extension_names_is_looked_in(tmp_path):
    text = urdf("x/y/a.stl").replace(b'"r">', b'"r"><mujoco><compiler meshdir="../parts/"/></mujoco>')
    put(tmp_path, **{"robots/r.urdf": text, "parts/a.stl": block()})
    bundle, found = gathered(tmp_path / "robots" / "r.urdf")
    assert (len(bundle.requests), found) == (2, ())


def test_moved_and_misspelt_files_are_found_by_a_unique_name_and_reported(tmp_path):
    names = ("package://gone/meshes/a.stl", "meshes/B.STL", "visual/c.stl", "/home/nobody/d.stl")
    put(tmp_path, **{"urdf/r.urdf": urdf(*names), "meshes/a.stl": block(), "other/b.stl": block()})
    put(tmp_path, **{"m/visual/c.stl": block(), "m/collision/c.stl": block("ply"), "d.stl": block()})
    bundle, found = gathered(tmp_path / "urdf" / "r.urdf")
    assert len(bundle.requests) == 5
    assert {one.code for one in found} == {"I-MESH-FOUND"}
    assert [one.message for one in found] == [
        "a.stl: not found in package://gone/meshes/, used from ../meshes/",
        "meshes/B.STL was not found; ../other/b.stl is used instead",
        "c.stl: not found in visual/, used from ../m/visual/",
        "d.stl: not found in elsewhere/1/, used from ../",
    ]


def test_where_several_files_have_the_name_none_is_guessed(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("x/a.stl"), "m/a.stl": block(), "n/a.stl": block()})
    (problem,) = refused(tmp_path / "r.urdf").problems
    assert (
        problem.message
        == "mesh x/a.stl: there is no such file, and several files have that name: m/a.stl, n/a.stl"
    )


def test_nothing_is_fetched_from_a_network(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("https://example.com/a.stl"), "a.stl": block()})
    (problem,) = refused(tmp_path / "r.urdf").problems
    assert "not downloaded" in problem.message


# Formats.


def coloured(kind: str) -> bytes:
    mesh = trimesh.creation.box(bounds=[(0, 0, 0), SIZE])
    mesh.visual.face_colors = [[255, 0, 0, 255]] * 6 + [[0, 0, 255, 255]] * 6
    data = mesh.export(file_type=kind)
    return data if isinstance(data, bytes) else data.encode()


@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "obj", "dae", "glb", "ply"])
def test_every_format_gives_the_same_solid(tmp_path, kind):
    name = f"a.{kind.partition('_')[0].upper()}"
    put(tmp_path, **{"r.urdf": urdf(name), name: block(kind)})
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
    code = (
        "import sys\n"
        "from pathlib import Path\n"
        "from linkwright.stages.fetch.urdf.meshes.companions import Companions\n"
        "from linkwright.stages.fetch.urdf.meshes.mesh_file import read\n"
        f"read(Path({str(tmp_path / 'a.stl')!r}).read_bytes(), 'a.stl', Companions())\n"
        "print('trimesh' in sys.modules)"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "False"


@pytest.mark.parametrize(("count", "why"), [(0, "no triangles"), (1, "NaN or infinite")])
def test_a_binary_stl_without_a_sound_triangle_is_refused(tmp_path, count, why):
    data = bytes(80) + struct.pack("<I", count) + struct.pack("<12fH", *[float("nan")] * 12, 0) * count
    put(tmp_path, **{"r.urdf": urdf("a.stl"), "a.stl": data})
    with pytest.raises(SourceError) as caught:
        gathered(tmp_path / "r.urdf")
    assert why in str(caught.value.problems[0])


def test_a_gltf_with_its_buffer_beside_it_is_read(tmp_path):
    scene = trimesh.Scene(trimesh.creation.box(bounds=[(0, 0, 0), SIZE]))
    files = trimesh.exchange.gltf.export_gltf(scene)
    put(tmp_path, **{"r.urdf": urdf("model.gltf"), **files})
    assert volume(only_body(tmp_path / "r.urdf")) == pytest.approx(0.008, rel=1e-6)


def test_scale_is_applied_and_a_mirroring_one_keeps_the_outside_outside(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("a.stl", more=' scale="2 -1 0.5"'), "a.stl": block()})
    body = only_body(tmp_path / "r.urdf")
    assert volume(body) == pytest.approx(0.008, rel=1e-6)
    np.testing.assert_allclose(
        [body.points.min(0), body.points.max(0)], [(0, -0.2, 0), (0.2, 0, 0.2)], atol=1e-7
    )


def test_colours_are_the_files_own_unless_the_robot_says_otherwise(tmp_path):
    blue = "<material><color rgba='0 0 0.5 1'/></material>"
    put(tmp_path, **{"r.urdf": urdf("a.ply"), "s.urdf": urdf("a.ply", inside=blue), "a.ply": coloured("ply")})
    body = only_body(tmp_path / "r.urdf")
    assert body.palette == ((0, 0, 1, 1), (1, 0, 0, 1))
    assert sorted(np.bincount(body.colours)) == [6, 6]
    assert only_body(tmp_path / "s.urdf").palette == ((0, 0, 0.5, 1),)


def test_materials_of_an_obj_are_its_colours(tmp_path):
    obj = """mtllib m.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
usemtl red
f 1 3 2
f 1 2 4
usemtl blue
f 1 4 3
f 2 3 4
"""
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


def test_images_of_a_gltf_that_are_no_colours_are_reported_as_lost(tmp_path):
    file = json.loads(trimesh.creation.box().export(file_type="gltf")["model.gltf"])
    buffers = trimesh.creation.box().export(file_type="gltf")
    file["images"] = [
        {"uri": "wood.png"},
        {"uri": "data:image/png;base64,AA==", "name": "logo"},
        {"bufferView": 0},
    ]
    files = {name: data for name, data in buffers.items() if name != "model.gltf"}
    put(tmp_path, **{"r.urdf": urdf("a.gltf"), "a.gltf": json.dumps(file).encode()}, **files)
    (lost,) = gathered(tmp_path / "r.urdf")[1]
    assert lost.code == "I-URDF-TEXTURE"
    assert "a.gltf (an image in it, logo, wood.png)" in lost.message


def test_a_collision_mesh_shows_no_image(tmp_path):
    text = urdf("a.obj").replace(b"visual>", b"collision>")
    mtl = b"newmtl red\nKd 1 0 0\nmap_Kd a.png\n"
    obj = b"mtllib m.mtl\nusemtl red\n" + trimesh.creation.box().export(file_type="obj").encode()
    put(tmp_path, **{"r.urdf": text, "a.obj": obj, "m.mtl": mtl})
    assert gathered(tmp_path / "r.urdf")[1] == ()


def test_a_shaded_mesh_has_few_colours(tmp_path):
    mesh = trimesh.creation.icosphere(subdivisions=3)
    shade = np.linspace(0, 255, len(mesh.faces)).astype(int)
    mesh.visual.face_colors = np.stack([shade, shade[::-1], shade, np.full_like(shade, 255)], axis=1)
    data = io.BytesIO(mesh.export(file_type="ply"))
    put(tmp_path, **{"r.urdf": urdf("a.ply"), "a.ply": data.getvalue()})
    assert 1 < len(only_body(tmp_path / "r.urdf").palette) <= 16


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


def test_a_dae_has_its_unit_and_its_nodes_and_loses_no_shape_for_want_of_an_image_or_a_material(tmp_path):
    put(tmp_path, **{"r.urdf": urdf("a.dae"), "a.dae": DAE.encode()})
    body = only_body(tmp_path / "r.urdf")
    assert volume(body) == pytest.approx(1 / 6)
    np.testing.assert_allclose(
        [body.points.min(0), body.points.max(0)], [(0, 0, 0.5), (1, 1, 1.5)], atol=1e-12
    )
    assert body.palette == (NEUTRAL, (1, 0, 0, 1), (1, 1, 1, 1))


def test_a_dae_of_which_a_shape_cannot_be_followed_is_refused(tmp_path):
    lost = DAE.replace("<node>", '<node><instance_geometry url="#lost"/></node><node>')
    put(tmp_path, **{"r.urdf": urdf("a.dae"), "a.dae": lost.encode()})
    (problem,) = refused(tmp_path / "r.urdf").problems
    assert problem.code == "E-MESH-READ"


# What is known beforehand.


@pytest.mark.parametrize(
    ("keys", "where"),
    [
        ({"path": "gone.urdf"}, "source.path"),
        ({"path": "."}, "source.path"),
        ({"path": "r.urdf", "packages": {"p": "gone"}}, "source.packages.p"),
    ],
)
def test_a_wrong_path_is_known_before_any_work(tmp_path, monkeypatch, keys, where):
    put(tmp_path, **{"r.urdf": urdf()})
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError) as caught:
        preflight(Plan.model_validate({"name": "r", "source": {"kind": "urdf", **keys}}), {})
    assert caught.value.where == where
