"""Triangles out of glTF: read, distinguished by the mass properties, or refused."""

import base64
import json
import struct

import numpy as np
import orjson
import pytest

from linkwright.stages.fetch.onshape import requests
from linkwright.stages.fetch.onshape.gather import digest, gather
from linkwright.stages.fetch.onshape.replies.recorded import RecordedAnswers
from linkwright.stages.fetch.onshape.triangles import faces, gltf_parts
from linkwright.stages.fetch.recording import Recording
from linkwright.stages.formats import triangles as codec
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.formats.meshes import gltf as reader
from linkwright.stages.robot.errors import ProtocolError
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.gltf import gltf
from tests.fake_onshape.studio_replies import mass_properties, tessellated_faces
from tests.support.building import bundle_of

RED, BLUE = (255, 0, 0), (0, 0, 255, 51)


def studio():
    """Four parts: two alike in different places, one with a coloured face, one without material."""
    made = Document("Shapes").studio("Shapes")
    pin = solids.cylinder(0.004, 0.03)
    made.part("Left pin", pin.moved(frame((0.05, 0, 0))), density=7800, colour=RED)
    made.part("Right pin", pin.moved(frame((-0.05, 0, 0.01))), density=7800)
    plate = solids.box(0.2, 0.1, 0.01, at=(0, 0, 0.2))
    made.part("Plate", plate, density=2700, colour=RED, face_colours={"+z": BLUE})
    made.part("Cover", solids.box(0.2, 0.09, 0.002, at=(0, 0, 0.25)))
    return made


def masses(of):
    return json.dumps(mass_properties(of, of.parts, as_group=False, overrides=True)).encode()


def from_faces(of):
    reply = tessellated_faces(of, of.parts, appearances=True, facet_normals=False, index_table=True)
    return body_arrays.decode(faces.compact(json.dumps(reply).encode()))


def assert_same(bodies, expected):
    assert set(bodies) == set(expected)
    for name, body in expected.items():
        ours = bodies[name]
        assert np.allclose(ours.palette, body.palette, atol=2e-6)
        assert [len(ours.points), len(ours.triangles)] == [len(body.points), len(body.triangles)]
        first, second = ({corners(mesh, row) for row in range(len(mesh.triangles))} for mesh in (ours, body))
        assert first == second


def corners(body, row):
    """A triangle's corners on the grid that solids are on, from its least on, and its colour."""
    points = [tuple((np.round(body.points[i], 7) + 0.0).tolist()) for i in body.triangles[row]]
    first = points.index(min(points))
    return (*points[first:], *points[:first], tuple(np.round(body.palette[body.colours[row]], 4).tolist()))


@pytest.mark.parametrize("up", ["z", "y"])
def test_bodies_are_distinguished_whichever_axis_is_up(up):
    of = studio()
    for order in ([0, 1, 2, 3], [3, 1, 0, 2]):
        reply = gltf(of.parts, appearances=True, up=up, order=order)
        assert_same(body_arrays.decode(gltf_parts.compact(reply, masses(of))), from_faces(of))


def test_a_node_that_is_named_by_a_part_id_is_that_part():
    of = studio()
    of.part("Twin cover", solids.box(0.2, 0.09, 0.002, at=(0, 0, 0.28)))
    twins = {part.id for part in of.parts[3:]}
    unnamed = codec.ids_with_triangles(gltf_parts.compact(gltf(of.parts, appearances=True), masses(of)))
    assert unnamed == {part.id for part in of.parts} - twins  # neither has a mass, so neither a place
    named = gltf(of.parts, appearances=True, name=lambda part, _: part.id)
    assert_same(body_arrays.decode(gltf_parts.compact(named, masses(of))), from_faces(of))


def test_bodies_that_match_no_parts_or_no_axis_are_refused():
    loose, other = Document("Loose").studio("Loose"), Document("Other").studio("Other")
    loose.part("Cover", solids.box(0.2, 0.09, 0.002))
    other.part("Ball", solids.ball(0.3), density=1000)
    broken = mass_properties(studio(), studio().parts, as_group=False, overrides=True)
    del broken["bodies"][studio().parts[0].id]["periphery"]
    for parts, figures, words in (
        (loose.parts, masses(loose), "with either axis up"),
        (studio().parts, masses(other), "none of the 4 bodies"),
        (studio().parts, json.dumps(broken).encode(), "do not identify the parts"),
    ):
        with pytest.raises(ProtocolError, match=words):
            gltf_parts.compact(gltf(parts, appearances=True), figures)


def test_masses_part_by_part_identify_all_bodies_of_a_recording():
    document = Document("Pair")
    made = document.studio("Shapes")
    made.part("Pin", solids.cylinder(0.004, 0.03), density=7800)
    made.part("Plate", solids.box(0.2, 0.1, 0.01, at=(0, 0, 0.2)), density=2700)
    root = document.assembly("Pair")
    for part in made.parts:
        root.add(part)
    bundle = bundle_of(document)
    (studio,) = bundle.studios
    definition = next(name for name, digest in bundle.requests.items() if digest == bundle.definition)
    figures = json.loads(masses(made))["bodies"]
    replies = {definition: bundle.blobs[bundle.definition]} | {
        requests.part_mass_properties(studio.key, part.id): orjson.dumps(
            {"bodies": {part.id: figures[part.id]}}
        )
        for part in made.parts
    }
    replies[requests.recorded_gltf(studio.key)] = gltf(made.parts, appearances=True)
    digests = {request: digest(body) for request, body in replies.items()}
    blobs = {digest(body): body for body in replies.values()}
    recording = Recording("onshape", "v16", bundle.root, bundle.definition, digests, blobs, {}, "v17")
    again = gather(RecordedAnswers(recording, "zip"))
    bodies = body_arrays.decode(again.blobs[again.studios[0].tessellation])
    assert set(bodies) == {part.id for part in made.parts}


def inlined(reply):
    """The JSON of a binary glTF, with its buffer in it."""
    size = struct.unpack_from("<I", reply, 12)[0]
    data, buffer = json.loads(reply[20 : 20 + size]), reply[28 + size :]
    uri = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    return {**data, "buffers": [{"byteLength": len(buffer), "uri": uri}]}


def test_buffers_in_json_and_transforms_of_nodes_are_read():
    part = studio().parts[2]
    plain = gltf([part], appearances=False)
    data = inlined(plain)
    # A child turned a quarter about z and doubled, in a parent moved by a matrix (by columns).
    quarter = [0, 0, 0.5**0.5, 0.5**0.5]
    data["nodes"] = [
        {"children": [1], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]},
        {"mesh": 0, "name": "child", "rotation": quarter, "scale": [2, 2, 2], "translation": [1, 0, 0]},
    ]
    (node,) = reader.read(json.dumps(data).encode())
    (before,) = reader.read(plain)
    x, y, z = before.points.T
    assert node.name == "child"
    assert np.allclose(node.points, np.stack([6 - 2 * y, 6 + 2 * x, 7 + 2 * z], axis=1), atol=1e-12)
    assert node.corners.tolist() == before.corners.tolist()


def test_a_file_that_is_cut_or_harmed_is_refused_or_read():
    reply = gltf(studio().parts[:1], appearances=True)
    rng = np.random.default_rng(1)
    refused = 0
    for _ in range(300):
        harmed = bytearray(reply)
        harmed[rng.integers(min(len(reply), 1500))] = rng.integers(256)
        try:
            reader.read(bytes(harmed))
        except ProtocolError:
            refused += 1
        with pytest.raises(ProtocolError):
            reader.read(reply[: rng.integers(len(reply))])
    assert refused > 50


def changed(**changes):
    """A glTF of one part as JSON, with changes in its accessors, bufferViews and the like, by index."""
    data = inlined(gltf(studio().parts[:1], appearances=True))
    for key, change in changes.items():
        if isinstance(change, dict):
            merged = data[key][0] | change
            data[key][0] = {name: value for name, value in merged.items() if value is not ...}
        else:
            data[key] = change
    return json.dumps(data).encode()


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"accessors": {"count": 10**12}}, "reaches beyond"),
        ({"accessors": {"count": 10**30}}, "not in the form"),
        ({"accessors": {"count": -1}}, "count is not a whole number"),
        ({"accessors": {"count": 1.5}}, "count is not a whole number"),
        ({"accessors": {"count": True}}, "count is not a whole number"),
        ({"accessors": {"count": ...}}, "count"),
        ({"accessors": {"byteOffset": 10**9}}, "reaches beyond"),
        ({"accessors": {"byteOffset": -4}}, "byteOffset is not a whole number"),
        ({"accessors": {"sparse": {"count": 10**9}}}, "not a plain VEC3"),
        ({"accessors": {"bufferView": ..., "count": 10**12}}, "not a plain VEC3"),
        ({"accessors": {"bufferView": 99}}, "IndexError"),
        ({"bufferViews": {"byteStride": 1}}, "a stride of 1"),
        ({"bufferViews": {"byteStride": 10**9}}, "a stride of 1000000000"),
        ({"bufferViews": {"byteStride": -12}}, "byteStride is not a whole number"),
        ({"bufferViews": {"byteLength": 12}}, "reaches beyond"),
        ({"bufferViews": {"byteLength": 10**12}}, "reaches beyond"),
        ({"bufferViews": {"byteLength": ...}}, "byteLength"),
        ({"bufferViews": {"byteOffset": 10**12}}, "reaches beyond"),
        ({"bufferViews": {"buffer": 7}}, "IndexError"),
        ({"buffers": [{"uri": "data:;base64,!!!!"}]}, "not in the form"),
        ({"buffers": [{"uri": "file:///etc/passwd"}]}, "outside of the file"),
        ({"buffers": [{"uri": 7}]}, "outside of the file"),
        ({"nodes": [{"children": [1, 1]}, {"mesh": 0}]}, "has two parents"),
        ({"nodes": [{"children": [n + 1, n + 1]} for n in range(63)] + [{"mesh": 0}]}, "has two parents"),
        ({"nodes": [{"mesh": 0}] * 150, "scenes": []}, "more than 100 nodes"),
        ({"nodes": [{"mesh": 0}] * 500, "scenes": []}, "used too often"),
        ({"nodes": [{"children": [0]}]}, "not in the form of glTF 2"),
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "not in the form of glTF 2"),
        ({"buffers": [{"uri": "https://example.com/mesh.bin"}]}, "not in the form of glTF 2"),
        ({"accessors": []}, "not in the form of glTF 2"),
        (
            {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5}]}]},
            "not in the form of glTF 2",
        ),
        ({"meshes": 7}, "not in the form of glTF 2"),
    ],
)
def test_a_gltf_that_claims_more_than_it_has_is_refused(monkeypatch, changes, why):
    monkeypatch.setattr(reader, "_MAX_NODES", 100 if "nodes" in why else 1000)
    monkeypatch.setattr(reader, "_MAX_NUMBERS", 300_000)
    with pytest.raises(ProtocolError, match=why):
        reader.read(changed(**changes))


def test_images_of_a_gltf_are_never_looked_at():
    """A picture of 10 GB, by its header, and one that is elsewhere."""
    images = [{"uri": "data:image/png;base64,AAAA"}, {"uri": "/dev/zero"}, {"bufferView": 10**9}]
    (node,) = reader.read(changed(images=images, textures=[{"source": 0}]))
    assert len(node.corners)
