"""Replies are bounded by their kind while they are unpacked, and in what they come to in memory."""

import base64
import gzip
import json
import struct
import tracemalloc
import zlib
from contextlib import contextmanager

import numpy as np
import pytest

from linkwright.stages.fetch.onshape import reply_sizes, requests
from linkwright.stages.fetch.onshape.api.client import Client
from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.api.decompression import DamagedError, UnknownEncodingError, unpacked
from linkwright.stages.fetch.onshape.replies.checks import check
from linkwright.stages.fetch.onshape.triangles import faces, json_stream, matching
from linkwright.stages.fetch.onshape.triangles.json_stream import Document, MalformedError
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.formats import triangles as codec
from linkwright.stages.formats.meshes import body_arrays, gltf
from linkwright.stages.robot.bundle import StudioKey
from linkwright.stages.robot.errors import ProtocolError, SourceError
from tests.fake_onshape.document import Document as Drawn
from tests.fake_onshape.faults import Fault
from tests.fake_onshape.gltf import gltf as drawn
from tests.fake_onshape.server import OnshapeServer
from tests.support.kept import QUICK
from tests.unit.fetch.onshape.triangles.test_faces import plain
from tests.unit.fetch.onshape.triangles.test_gltf import opened, studio

STUDIO = StudioKey("d" * 24, "m/" + "m" * 24, "e" * 24, "default")
PLACE = ("d" * 24, "m/" + "m" * 24, "e" * 24)
MB = 1 << 20


class Fine:
    angle, chord, max_facet_width = 0.2, 0.0005, None


@pytest.mark.parametrize(
    ("request_", "most"),
    [
        (requests.definition(*PLACE, "default"), 64),
        (requests.assembly_mass_properties(*PLACE, "default"), 1),
        (requests.mass_properties(STUDIO, "r"), 32),
        (requests.part_mass_properties(STUDIO, "JHD"), 32),
        (requests.tessellated_faces(STUDIO, "r", Fine), 1024),
        (requests.recorded_faces(STUDIO), 1024),
        (requests.gltf(STUDIO, "r", Fine), 512),
        (requests.features(STUDIO, "r"), 32),
        (requests.variables(STUDIO, "r"), 16),
        (requests.variable_studio("d", "w", "e"), 16),
        (requests.configuration(*PLACE), 16),
        (requests.current_microversion("d", "w"), 1),
        (requests.elements("d", "m"), 16),
        (requests.tabs("d", "w"), 16),
        ("the definition", 64),
        ("/something/new", 16),
    ],
)
def test_each_kind_of_reply_has_its_bound(request_, most):
    assert reply_sizes.largest(request_) == most * MB


@contextmanager
def answering(**fault):
    """A question to a local Onshape that meets this fault whatever is asked, and the list of requests."""
    with OnshapeServer(Drawn("Empty"), fault=lambda *_: Fault(**fault)) as server:
        url = AssemblyUrl(server.url, "D", "w/W", "ROOT", "default")
        with Client(url, Credentials("access-key", "secret-key"), patience=QUICK) as client:
            assert client._wire._http.headers["Accept-Encoding"] == "gzip"
            yield lambda: client.get(requests.mass_properties(STUDIO, "r")), server.calls


def bomb(size, times=1):
    """This number of zeros, packed this number of times over."""
    packed = b"".join(_packed_zeros(size))
    for _ in range(times - 1):
        packed = gzip.compress(packed, 9)
    return packed


def _packed_zeros(size):
    pack = zlib.compressobj(9, zlib.DEFLATED, 31)
    piece = bytes(MB)
    for _ in range(size // MB):
        yield pack.compress(piece)
    yield pack.flush()


GZIP = {"Content-Encoding": "gzip"}


def test_a_reply_that_unpacks_to_more_than_its_kind_may_have_is_left_unread():
    with answering(body=bomb(96 * MB), headers=GZIP) as (ask, calls):
        assert peak_of(ask) < 8 * MB
        with pytest.raises(ProtocolError, match="larger than the limit \\(32 MB\\)"):
            ask()
        assert len(calls) == 2


REFUSAL = gzip.compress(json.dumps({"message": "no"}).encode() + b" " * (16 * MB))
PACKINGS = ("gzip, gzip", "gzip,gzip", "br", "zstd", "deflate", "x\x1b[2J")
BODY = gzip.compress(b"{}" * 1000)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ({"body": b"{}", "claimed": 33 * MB}, "larger than the limit"),
        ({"body": b" " * 65536, "endless": True}, "larger than the limit \\(4 MB\\)"),
        ({"status": 403, "body": REFUSAL, "headers": GZIP}, "403"),
        ({"body": BODY[:-4], "headers": GZIP}, "cut short; tried 2 times"),
        *(
            (fault | {"headers": {"Content-Encoding": packing}}, words)
            for packing in PACKINGS
            for fault, words in (
                ({"body": bomb(8 * MB, 2)}, "has an unexpected encoding"),
                ({"status": 403, "body": bomb(MB, 2)}, "403"),
            )
        ),
    ],
)
def test_a_reply_beyond_its_bounds_or_in_another_packing_is_refused(monkeypatch, fault, words):
    if fault.get("endless"):
        monkeypatch.setattr(reply_sizes, "_BY_PATH", [(r"/massproperties$", 4 * MB)])
    with answering(**fault) as (ask, _), pytest.raises(SourceError, match=words) as caught:
        ask()
    assert "\x1b" not in str(caught.value)


@pytest.mark.parametrize("pieces", [1, 7, 100_000])
def test_gzip_of_one_member_or_several_is_unpacked(pieces):
    body = json.dumps({"bodies": list(range(50_000))}).encode()
    packed = gzip.compress(body[:1000]) + gzip.compress(b"") + gzip.compress(body[1000:])
    cut = [packed[at : at + pieces] for at in range(0, len(packed), pieces)]
    assert b"".join(unpacked(cut, "gzip")) == body
    assert b"".join(unpacked(cut, "")) == packed
    assert max(map(len, unpacked([bomb(16 * MB)], "gzip"))) <= 1 << 18


def test_what_is_harmed_is_reported():
    for harmed in (BODY[:-1], BODY[:-9], BODY[:3], b"no gzip at all", BODY + b"and more"):
        with pytest.raises(DamagedError):
            list(unpacked([harmed], "gzip"))
    with pytest.raises(UnknownEncodingError, match="gzip, gzip"):
        unpacked([BODY], "gzip, gzip")


def peak_of(refused):
    """The most memory that `refused`, which must raise ProtocolError, takes [bytes]."""
    tracemalloc.start()
    try:
        with pytest.raises(ProtocolError):
            refused()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("start", "piece", "times", "end"),
    [
        (b"[", b"[],", 400_000, b"[]]"),
        (b'{"bodies":[', b"{},", 400_000, b"{}]}"),
        (b'{"bodies": [1', b",1", 4_500_000, b"]}"),
        (b'{"bodies": [{"id": "A", "faces": [{"facets": [{"indices": [0', b",0", 4_500_000, b"]}]}]}]}"),
        (b'{"bodies": [{"id": "', b"A", 9_000_000, b'"}]}'),
    ],
    ids=["brackets", "bodies", "numbers", "indices", "name"],
)
def test_a_text_that_would_take_many_times_its_size_is_refused(start, piece, times, end):
    text = start + piece * times + end
    # A block of the text is looked at in 40 times its size, the whole text in 4 times.
    assert peak_of(lambda: faces.compact(text)) < 4 * len(text) + 40 * json_stream._BLOCK


def test_a_text_that_is_nested_without_end_is_refused():
    for text in (b"[" * 100_000 + b"]" * 100_000, b'{"a":' * 50_000 + b"1" + b"}" * 50_000):
        with pytest.raises(MalformedError):
            plain(Document(text).root())
    with pytest.raises(ProtocolError):
        codec.require_compact(codec.MAGIC + struct.pack("<I", 200_000) + b"[" * 200_000)


def test_few_triangles_that_are_many_are_refused(monkeypatch):
    monkeypatch.setattr(faces.Room.__init__, "__defaults__", (1000, 3000, 20))
    point = '{"x": 0, "y": 0, "z": 0}'

    def body(name, facets, **more):
        return {"id": name, "faces": [{"facets": facets}], "facetPoints": [[0, 0, 0]] * 3, **more}

    fan = body("A", [{"indices": [0] * 1003}])
    mesh = body("A", [{"indices": [0] * 202}])
    parts = [mesh, *({"id": f"C{n}", "constituents": ["A"]} for n in range(10))]
    loose = {"id": "A", "faces": [{"facets": [{"vertices": [json.loads(point)] * 3001}]}]}
    shared = {"bodies": [{"id": f"B{n}"} for n in range(4)], "facetPoints": [[0, 0, 0]] * 1000}
    for reply in ([fan], parts, [loose], [{"id": f"B{n}"} for n in range(21)], shared):
        with pytest.raises(ProtocolError, match="more than"):
            faces.read(json.dumps(reply).encode())
    assert len(faces.read(json.dumps(parts[:4]).encode())) == 4


def test_more_colours_than_are_kept_are_reported(monkeypatch):
    monkeypatch.setattr(body_arrays, "_MAX_COLOURS", 100)
    facets = [{"indices": [0, 1, 2]}]
    drawn = [{"appearance": {"color": [n >> 16, n >> 8, n & 255]}, "facets": facets} for n in range(101)]
    reply = [{"id": "A", "faces": drawn, "facetPoints": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}]
    with pytest.raises(ProtocolError, match="101 colours"):
        faces.compact(json.dumps(reply).encode())


def test_a_compact_form_with_a_header_that_is_none_is_refused():
    for header in (b'{"bodies":[{"id":"A","points":0,"triangles":0,"palette":["abcd"]}]}', b"[]", b"7"):
        with pytest.raises(ProtocolError):
            codec.require_compact(codec.MAGIC + struct.pack("<I", len(header)) + header)
    with pytest.raises(ProtocolError, match="its header has"):
        codec.require_compact(codec.MAGIC + struct.pack("<I", 1 << 31))


def changed(**changes):
    """A glTF of one part as JSON, with changes in its accessors, bufferViews and the like, by index."""
    data, buffer = opened(drawn(studio().parts[:1], appearances=True))
    uri = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    data["buffers"] = [{"byteLength": len(buffer), "uri": uri}]
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
    ],
)
def test_a_gltf_that_claims_more_than_it_has_is_refused(monkeypatch, changes, why):
    monkeypatch.setattr(gltf, "_MAX_NODES", 100 if "nodes" in why else 1000)
    monkeypatch.setattr(gltf, "_MAX_NUMBERS", 300_000)
    with pytest.raises(ProtocolError, match=why):
        gltf.read(changed(**changes))


def test_images_of_a_gltf_are_never_looked_at():
    """A picture of 10 GB, by its header, and one that is elsewhere."""
    images = [{"uri": "data:image/png;base64,AAAA"}, {"uri": "/dev/zero"}, {"bufferView": 10**9}]
    (node,) = gltf.read(changed(images=images, textures=[{"source": 0}]))
    assert len(node.corners)


def test_the_error_about_a_reply_does_not_keep_what_it_was_parsed_to():
    """Errors of several replies are kept until the build ends: together they would fill the memory."""
    body, many = b'{"bodies":[' + b"[]," * 200_000 + b"[]]}", 200_000
    tracemalloc.start()
    try:
        with pytest.raises(ProtocolError, match="has no bodies") as raised:
            check("/partstudios/d/a/m/b/e/c/massproperties?partId=", body)
        held, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert raised.value.__traceback__
    assert peak > 50 * many  # an empty list takes 56 bytes
    assert held < many


def test_a_gltf_of_brackets_is_refused_before_it_is_parsed():
    text = b'{"nodes":[' + b"[]," * 4_200_000 + b"[]]}"
    assert peak_of(lambda: gltf.read(text)) < MB


def test_bodies_and_parts_beyond_counting_are_refused(monkeypatch):
    monkeypatch.setattr(matching, "_MAX_PAIRS", 5)
    shape = matching.BodyFigures("", 1.0, 1.0, 1.0, None, None)
    with pytest.raises(ValueError, match="3 bodies and 2 parts"):
        matching.assigned([shape] * 3, {"A": shape, "B": shape})


def test_the_index_of_a_text_is_small():
    """Eight bytes for each list, whatever is in it."""
    document = Document(json.dumps([[0.25, 0.5, 0.75]] * 1000).encode())
    assert document._begins[2].dtype == np.uint32
    assert len(document._begins[2]) == 1000
    assert len("[0,0,0],") > json_stream._BYTES_EACH
