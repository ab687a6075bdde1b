"""Replies are bounded by their kind while they are unpacked, and in what they come to in memory."""

import gzip
import json
import struct
import tracemalloc
import zlib
from contextlib import contextmanager

import pytest

from linkwright.stages.fetch.onshape import reply_sizes, requests
from linkwright.stages.fetch.onshape.api.decompression import DamagedError, UnknownEncodingError, decompressed
from linkwright.stages.fetch.onshape.replies.checks import check
from linkwright.stages.fetch.onshape.triangles import faces, json_stream, matching
from linkwright.stages.fetch.onshape.triangles.json_stream import Document, MalformedError
from linkwright.stages.formats import triangles as codec
from linkwright.stages.formats.meshes import body_arrays, gltf
from linkwright.stages.robot.bundle import ElementKey
from linkwright.stages.robot.errors import ProtocolError, SourceError
from tests.fake_onshape.document import Document as Drawn
from tests.fake_onshape.faults import Fault
from tests.fake_onshape.server import OnshapeServer
from tests.support.kept import client_at
from tests.unit.fetch.onshape.triangles.test_faces import plain

STUDIO = ElementKey("d" * 24, "m/" + "m" * 24, "e" * 24, "default")
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
def test_a_kind_of_reply_has_its_bound(request_, most):
    assert reply_sizes.largest(request_) == most * MB


@contextmanager
def answering(**fault):
    """A question to a local Onshape that meets this fault whatever is asked."""
    server = OnshapeServer(Drawn("Empty"), fault=lambda *_: Fault(**fault))
    with server, client_at(server.url) as client:
        assert client._wire._http.headers["Accept-Encoding"] == "gzip"
        yield lambda: client.get(requests.mass_properties(STUDIO, "r"))


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


REFUSAL = gzip.compress(json.dumps({"message": "no"}).encode() + b" " * (16 * MB))
PACKINGS = ("gzip, gzip", "gzip,gzip", "br", "zstd", "deflate", "x\x1b[2J")
BODY = gzip.compress(b"{}" * 1000)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ({"body": b"{}", "claimed": 33 * MB}, "larger than the limit \\(32 MB\\)"),
        ({"body": bomb(48 * MB), "headers": GZIP}, "larger than the limit \\(32 MB\\)"),
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
def test_a_reply_beyond_bounds_or_in_odd_packing_is_refused(monkeypatch, fault, words):
    if fault.get("endless"):
        monkeypatch.setattr(reply_sizes, "_BY_PATH", [(r"/massproperties$", 4 * MB)])
    with answering(**fault) as ask, pytest.raises(SourceError, match=words) as caught:
        ask()
    assert "\x1b" not in str(caught.value)


@pytest.mark.parametrize("pieces", [1, 7, 100_000])
def test_gzip_of_one_member_or_several_is_unpacked(pieces):
    body = json.dumps({"bodies": list(range(50_000))}).encode()
    packed = gzip.compress(body[:1000]) + gzip.compress(b"") + gzip.compress(body[1000:])
    cut = [packed[at : at + pieces] for at in range(0, len(packed), pieces)]
    assert b"".join(decompressed(cut, "gzip")) == body
    assert b"".join(decompressed(cut, "")) == packed
    assert max(map(len, decompressed([bomb(16 * MB)], "gzip"))) <= 1 << 18


def test_a_harmed_body_is_reported():
    for harmed in (BODY[:-1], BODY[:-9], BODY[:3], b"no gzip at all", BODY + b"and more"):
        with pytest.raises(DamagedError):
            list(decompressed([harmed], "gzip"))
    with pytest.raises(UnknownEncodingError, match="gzip, gzip"):
        decompressed([BODY], "gzip, gzip")


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
    monkeypatch.setattr(faces.MemoryBudget.__init__, "__defaults__", (1000, 3000, 20))
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
    with pytest.raises(ProtocolError, match="their header has"):
        codec.require_compact(codec.MAGIC + struct.pack("<I", 1 << 31))


def test_an_error_about_a_reply_does_not_keep_its_tree():
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
        matching.assign_meshes([shape] * 3, {"A": shape, "B": shape})
