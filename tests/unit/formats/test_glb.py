"""GLB files read back by trimesh and by their own JSON, and glTF of others, whose claims are checked before a
library reads them."""

import io
import json
import os
import struct
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from linkwright.stages.fetch.urdf.meshes.companions import Companions
from linkwright.stages.fetch.urdf.meshes.mesh_file import Unreadable, read
from linkwright.stages.formats.meshes import glb, gltf, gltf_claims
from linkwright.stages.formats.meshes.surface import Surface, round_to_single
from tests.fake_onshape.gltf import gltf as drawn
from tests.support.textures import cube, image, ordered
from tests.unit.fetch.onshape.triangles.test_gltf import changed, studio

GREY = (0.7, 0.7, 0.7, 1.0)


def surface(mesh):
    return round_to_single(Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces).astype(np.int64)))


def cylinder(sections=32):
    return surface(trimesh.creation.cylinder(0.1, 0.3, sections=sections))


def tree(data):
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + length])


def meshes(data):
    scene = trimesh.load_scene(io.BytesIO(data), file_type="glb", process=False)
    return [scene.geometry[scene.graph[node][1]] for node in sorted(scene.graph.nodes_geometry)]


def attribute(data, primitive, name):
    """The vectors of a primitive, by the tables of the file alone."""
    root = tree(data)
    accessor = root["accessors"][root["meshes"][0]["primitives"][primitive]["attributes"][name]]
    view = root["bufferViews"][accessor["bufferView"]]
    start = 20 + struct.unpack_from("<I", data, 12)[0] + 8 + view["byteOffset"]
    rows = np.frombuffer(data[start : start + view["byteLength"]], "<f4")
    return rows.reshape(accessor["count"], -1).astype(np.float64)


def test_triangles_are_those_of_the_surface_to_the_bit():
    original = cylinder()
    (mesh,) = meshes(glb.write([glb.Piece(original, GREY)]))
    assert np.array_equal(mesh.triangles.astype(np.float32), original.corners.astype(np.float32))


def test_the_default_scene_is_named():
    """Without it, the standard lets a viewer show nothing."""
    document = tree(glb.write([glb.Piece(cylinder(), GREY)]))
    assert document["scenes"][document["scene"]] == {"nodes": [0]}


def test_normals_follow_round_faces_and_turn_at_edges():
    data = glb.write([glb.Piece(cylinder(), GREY)])
    points, normals = attribute(data, 0, "POSITION"), attribute(data, 0, "NORMAL")
    round_, flat = np.abs(normals[:, 2]) < 0.5, np.abs(normals[:, 2]) >= 0.5
    # Two points a corner of the rim, one in the middle of each cap.
    assert (round_.sum(), flat.sum()) == (2 * 32, 2 * 33)
    expected = np.concatenate([points[round_, :2] / 0.1, np.zeros((64, 1))], axis=1)
    # The mean of the two faces by area is off by at most half the angle between faces.
    assert np.abs(normals[round_] - expected).max() < np.radians(360 / 32) / 2
    assert np.allclose(normals[flat], np.sign(points[flat, 2:]) * [0, 0, 1], atol=1e-6)
    assert np.abs(np.linalg.norm(normals, axis=1) - 1).max() < 1e-6


def test_box_has_three_normals_at_each_corner():
    data = glb.write([glb.Piece(surface(trimesh.creation.box((1, 2, 3))), GREY)])
    assert len(attribute(data, 0, "NORMAL")) == 24
    (mesh,) = meshes(data)
    assert np.allclose(mesh.vertex_normals[mesh.faces], mesh.face_normals[:, None])


def test_triangle_without_area_has_a_unit_normal():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]])
    data = glb.write([glb.Piece(Surface(points, np.array([[0, 1, 2], [0, 2, 3]])), GREY)])
    assert np.allclose(np.linalg.norm(attribute(data, 0, "NORMAL"), axis=1), 1)


def test_colours_are_in_linear_light_and_come_back_exactly():
    colours = [(0.0, 0.02, 0.04045, 1.0), (0.5, 0.25, 0.75, 0.5), (1.0, 0.956863, 0.7, 1.0)]
    data = glb.write([glb.Piece(cylinder(8), colour) for colour in colours])
    materials = tree(data)["materials"]
    for colour, material in zip(colours, materials, strict=True):
        look = material["pbrMetallicRoughness"]
        linear = np.array(look["baseColorFactor"])
        # The standard's own formula, IEC 61966-2-1.
        low = np.array(colour[:3]) <= 0.04045
        shown = np.where(low, np.array(colour[:3]) / 12.92, ((np.array(colour[:3]) + 0.055) / 1.055) ** 2.4)
        assert np.allclose(linear[:3], shown, rtol=0, atol=1e-8)
        assert linear[3] == colour[3]
        assert (look["metallicFactor"], look["roughnessFactor"]) == (0.0, 0.5)
    assert [material.get("alphaMode", "OPAQUE") for material in materials] == ["OPAQUE", "BLEND", "OPAQUE"]
    (node,) = gltf.read(data)
    assert np.allclose(node.colours, colours, rtol=0, atol=1e-6)


def test_open_surface_is_seen_from_behind():
    whole = cylinder(8)
    half = Surface(whole.vertices, whole.triangles[::2])
    materials = tree(glb.write([glb.Piece(whole, GREY), glb.Piece(half, GREY)]))["materials"]
    assert [material.get("doubleSided", False) for material in materials] == [False, True]


def test_corners_have_places_in_an_image_that_is_there_once():
    corners = cube()
    points, place = np.unique(corners[..., :3].reshape(-1, 3), axis=0, return_inverse=True)
    body = Surface(points, place.reshape(-1, 3), corners[..., 3:].astype(np.float32))
    pieces = [glb.Piece(body, GREY, image()), glb.Piece(body, (0.5, 0.5, 0.5, 1.0), image())]
    data = glb.write(pieces)
    root = tree(data)
    assert len(root["images"]) == len(root["textures"]) == 1
    assert data.count(image()) == 1
    for mesh in meshes(data):
        assert mesh.visual.material.baseColorTexture.size == (4, 4)
        # trimesh turns v, so that it is upwards.
        read_back = np.concatenate([mesh.vertices, mesh.visual.uv], axis=1)[mesh.faces]
        assert np.allclose(ordered(read_back), ordered(corners), atol=1e-6)


@pytest.mark.parametrize("up", ["z", "y"])
def test_axis_that_is_up_turns_the_scene_and_not_the_points(up):
    box = surface(trimesh.creation.box(bounds=[(0, 0, 0), (1, 2, 3)]))
    data = glb.write([glb.Piece(box, GREY)], up)
    scene = trimesh.load_scene(io.BytesIO(data), file_type="glb")
    wanted = {"z": [(0, 0, 0), (1, 2, 3)], "y": [(0, 0, -2), (1, 3, 0)]}[up]
    assert np.allclose(scene.bounds, wanted, atol=1e-6)
    (node,) = gltf.read(data)
    assert np.array_equal([node.points.min(axis=0), node.points.max(axis=0)], [(0, 0, 0), (1, 2, 3)])


@pytest.mark.parametrize(("count", "kind"), [(65_000, 5123), (66_000, 5125)])
def test_large_meshes_have_wider_indices(count, kind):
    points = np.random.default_rng(0).random((count, 3))
    triangles = np.arange(count - count % 3).reshape(-1, 3)
    data = glb.write([glb.Piece(round_to_single(Surface(points, triangles)), GREY)])
    root = tree(data)
    assert root["accessors"][root["meshes"][0]["primitives"][0]["indices"]]["componentType"] == kind
    assert len(meshes(data)[0].faces) == len(triangles)


def test_file_is_as_large_as_it_says():
    data = glb.write([glb.Piece(cylinder(7), GREY), glb.Piece(cylinder(5), (0.1, 0.2, 0.3, 0.4))])
    gltf_claims.check_claims(data, {})
    assert len(data) % 4 == 0
    for view in tree(data)["bufferViews"]:
        assert view["byteOffset"] % 4 == 0
    for primitive in range(2):
        points = attribute(data, primitive, "POSITION")
        accessor = tree(data)["accessors"][3 * primitive]
        bounds = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        assert (accessor["min"], accessor["max"]) == bounds


PROGRAM = """
import hashlib, numpy as np
from linkwright.stages.formats.meshes import glb
from linkwright.stages.formats.meshes.surface import Surface
rng = np.random.default_rng(1)
body = Surface(rng.random((50, 3)), rng.integers(0, 50, (200, 3)))
data = glb.write([glb.Piece(body, (k / 9, 0.5, 0.2, 1.0)) for k in range(9)])
print(hashlib.sha256(data).hexdigest())
"""


def test_bytes_do_not_depend_on_the_seed_of_hashes():
    command = [sys.executable, "-c", PROGRAM]
    environs = [{**os.environ, "PYTHONHASHSEED": seed} for seed in ("0", "1")]
    assert len({subprocess.check_output(command, env=environ) for environ in environs}) == 1


def test_gltf_with_all_that_it_claims_is_read():
    scene = trimesh.Scene([trimesh.creation.box(), trimesh.creation.icosphere()])
    scene.add_geometry(trimesh.creation.cone(0.1, 0.2), parent_node_name="geometry_0")
    files = trimesh.exchange.gltf.export_gltf(scene)
    buffers = {name: data for name, data in files.items() if name != "model.gltf"}
    assert len(read(files["model.gltf"], "a.gltf", Companions(buffers)).triangles)
    assert len(read(trimesh.exchange.gltf.export_glb(scene), "a.glb", Companions()).triangles)
    assert len(read(changed(), "a.gltf", Companions()).triangles)


@pytest.mark.parametrize(("changes", "why"), [
    ({"accessors": {"count": 10**12}}, "which are not there"),
    ({"accessors": {"count": -1}}, "count is not a whole number"),
    ({"accessors": {"count": 1.5}}, "count is not a whole number"),
    ({"accessors": {"bufferView": ..., "count": 10**12}}, "which are not there"),
    ({"accessors": {"bufferView": ..., "sparse": {"count": 1}, "count": 10**12}}, "which are not there"),
    ({"accessors": {"byteOffset": 10**9}}, "which are not there"),
    ({"bufferViews": {"byteStride": 1}}, "a stride of 1"),
    ({"bufferViews": {"byteLength": 10**12}}, "view 0 reaches beyond"),
    ({"buffers": [{"byteLength": 10**12, "uri": "elsewhere.bin"}]}, "reaches beyond"),
    ({"nodes": [{"children": [0]}], "scenes": [{"nodes": [0]}]}, "do not form a tree"),
    ({"nodes": [*({"children": [n, n]} for n in range(1, 60)), {"mesh": 0}]}, "do not form a tree"),
    (
        {"nodes": [{"children": [1, 2]}, {"children": [3]}, {"children": [3]}, {"mesh": 0}]},
        "do not form a tree",
    ),
    ({"nodes": [{"mesh": 0}] * 500, "scenes": []}, "used too often"),
    ({"meshes": 7}, "damaged"),
])  # fmt: skip
def test_gltf_that_claims_more_than_it_has_is_refused(monkeypatch, changes, why):
    monkeypatch.setattr(gltf, "_MAX_NUMBERS", 100_000)
    with pytest.raises(Unreadable, match=why):
        read(changed(**changes), "a.gltf", Companions())


def test_text_of_brackets_is_refused_before_it_is_parsed(monkeypatch):
    monkeypatch.setattr(gltf_claims, "MAX_VALUES", 100)
    with pytest.raises(Unreadable, match="larger than the limit"):
        read(b'{"nodes":[' + b"[]," * 1000 + b"[]]}", "a.gltf", Companions())
    with pytest.raises(Unreadable):
        read(b"[" * 100_000, "a.gltf", Companions())


def test_buffer_beside_the_file_is_measured():
    reply = drawn(studio().parts[:1], appearances=True)
    data, buffer = tree(reply), reply[28 + struct.unpack_from("<I", reply, 12)[0] :]
    data["buffers"] = [{"byteLength": len(buffer), "uri": "a%20b.bin"}]
    text = json.dumps(data).encode()
    assert len(read(text, "a.gltf", Companions({"a%20b.bin": buffer})).triangles)
    with pytest.raises(Unreadable, match="reaches beyond"):
        read(text, "a.gltf", Companions({"a%20b.bin": buffer[:100]}))
