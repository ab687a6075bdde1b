"""glTF of a robot's own file: what it claims is held against what it has before a library reads it."""

import base64
import json

import pytest
import trimesh

from linkwright.stages.fetch.urdf.meshes.companions import Companions
from linkwright.stages.fetch.urdf.meshes.mesh_file import Unreadable, read
from linkwright.stages.formats.meshes import gltf, gltf_claims
from tests.fake_onshape.gltf import gltf as drawn
from tests.unit.fetch.onshape.triangles.test_gltf import changed, inlined, studio


def test_what_has_what_it_claims_is_read():
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
def test_what_claims_more_than_it_has_is_refused(monkeypatch, changes, why):
    monkeypatch.setattr(gltf, "_MAX_NUMBERS", 100_000)
    with pytest.raises(Unreadable, match=why):
        read(changed(**changes), "a.gltf", Companions())


def test_a_text_of_brackets_is_refused_before_it_is_parsed(monkeypatch):
    monkeypatch.setattr(gltf_claims, "MAX_VALUES", 100)
    with pytest.raises(Unreadable, match="larger than the limit"):
        read(b'{"nodes":[' + b"[]," * 1000 + b"[]]}", "a.gltf", Companions())
    with pytest.raises(Unreadable):
        read(b"[" * 100_000, "a.gltf", Companions())


def test_a_buffer_beside_the_file_is_measured():
    data = inlined(drawn(studio().parts[:1], appearances=True))
    buffer = base64.b64decode(data["buffers"][0]["uri"].partition(",")[2])
    data["buffers"] = [{"byteLength": len(buffer), "uri": "a%20b.bin"}]
    text = json.dumps(data).encode()
    assert len(read(text, "a.gltf", Companions({"a%20b.bin": buffer})).triangles)
    with pytest.raises(Unreadable, match="reaches beyond"):
        read(text, "a.gltf", Companions({"a%20b.bin": buffer[:100]}))
