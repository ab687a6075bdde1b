"""Replies and files that would fill the memory: one message, within a bound that a small computer has.

Each build runs in a process whose memory is limited, so that a failure cannot take this computer down.
"""

import gzip
import itertools
import json
import subprocess
import zlib
from functools import cache, partial

import pytest

from tests.fake_onshape.faults import Fault
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import COMMAND, environment
from tests.support.faulty import desk

resource = pytest.importorskip("resource")
pytestmark = pytest.mark.slow

MB = 1 << 20
ALLOWED = 3 << 30
"""Address space of a build [bytes]: libraries take a third of it."""

GZIP = {"Content-Encoding": "gzip"}


def packed(*pieces):
    """Pieces, each so many times, as one gzip stream; no more than a megabyte is ever in memory."""
    pack = zlib.compressobj(9, zlib.DEFLATED, 31)
    return b"".join([*(pack.compress(run) for run in _runs(pieces)), pack.flush()])


def _runs(pieces):
    for piece, times in pieces:
        many = max(1, MB // len(piece))
        yield from itertools.repeat(piece * many, times // many)
        yield piece * (times % many)


def limited(here, *arguments, **environ):
    """What a build that must fail says; it may take no more memory than is allowed."""
    done = subprocess.run(
        [str(COMMAND), *arguments],
        cwd=here,
        env=environment(here, OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", **environ),
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (ALLOWED, ALLOWED)),
    )
    assert done.returncode in (1, 2), done.stderr
    assert done.stderr.count("error:") == 1
    assert "a bug in linkwright" not in done.stderr, done.stderr
    return done.stderr


DEFINITION, MASS, TRIANGLES, GLTF = "/assemblies/", "/massproperties", "/tessellatedfaces", "/gltf"
BODY = b'{"bodies":[{"id":"JHD","faces":['


def twice_packed():
    return gzip.compress(packed((bytes(MB), 4000)), 9)


@cache
def endless():
    return packed((b" " * MB, 2000))


FACETS = b'"facetPoints":[[0,0,0]],"faces":[{"facets":['
MANY, LAST = b'{"indices":[' + b"0," * 60_000 + b"0]},", b'{"indices":[0,0,0]}]}]}'
DEFINITION_HEAD, BODIES, CONSTITUENT = (
    b'{"rootAssembly":{"instances":[',
    b'{"bodies":[',
    b'{"id":"C","constituents":["A"]}',
)

PIECES = {
    "a definition of nothing": (
        DEFINITION, "definition", (DEFINITION_HEAD, 1), (b"[],", 18_000_000), (b"[]]}}", 1)
    ),
    "a mass reply of nothing": (MASS, "no bodies", (BODIES, 1), (b"[],", 10_000_000), (b"[]]}", 1)),
    "triangles of brackets": (TRIANGLES, "brackets", (BODIES, 1), (b"{},", 30_000_000), (b"{}]}", 1)),
    "a facet that is a million": (
        TRIANGLES, "not made of lists", (BODY + b'{"facets":[{"indices":[0', 1), (b",0", 20_000_000),
        (b"]}]}]}]}", 1),
    ),
    "facets that are many triangles": (
        TRIANGLES, "more than", (b'{"bodies":[{"id":"JHD",' + FACETS, 1), (MANY, 1000), (LAST + b"]}", 1)
    ),
    "composites of the same": (
        TRIANGLES, "more than", (b'{"bodies":[{"id":"A",' + FACETS, 1), (MANY, 20), (LAST, 1),
        (b"," + CONSTITUENT, 20_000), (b"]}", 1),
    ),
}  # fmt: skip
# The bodies are made where they are used: packing each takes seconds.
REPLIES = {
    "packed twice": (MASS, twice_packed, {"Content-Encoding": "gzip, gzip"}, "unexpected encoding"),
    "a definition without end": (DEFINITION, endless, GZIP, "(64 MB)"),
    "a mass reply without end": (MASS, endless, GZIP, "(32 MB)"),
    "triangles without end": (TRIANGLES, endless, GZIP, "(1024 MB)"),
    **{name: (place, partial(packed, *row), GZIP, words) for name, (place, words, *row) in PIECES.items()},
}


@pytest.mark.parametrize("name", REPLIES)
def test_a_reply_that_would_fill_the_memory_is_one_message(tmp_path, name):
    place, make, headers, output_text = REPLIES[name]
    body = make()

    def fault(_, target, __):
        if GLTF in target:  # which stands in for triangles that are declined
            return Fault(400, b"{}")
        return Fault(body=body, headers=headers) if place in target else None

    with OnshapeServer(desk(), fault=fault) as server:
        url = f"source.url='{server.document_url()}'"
        assert output_text in limited(tmp_path, "source=onshape", url, **server.environ)


def gltf_of(count, **more):
    """A glTF whose accessors claim so many numbers."""
    uri = "data:application/octet-stream;base64," + "AAAA" * 12
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"},
        {"bufferView": 0, "componentType": 5125, "count": 3, "type": "SCALAR"},
    ]
    data = {
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": 36, "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": accessors,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}], "nodes": [{"mesh": 0}],
    }  # fmt: skip
    return json.dumps(data | more).encode()


GLTFS = {
    "a count": gltf_of(10**10),
    "a stride of none": gltf_of(10**9, bufferViews=[{"buffer": 0, "byteLength": 36, "byteStride": 0}]),
    "no view": gltf_of(3, accessors=[{"componentType": 5126, "count": 10**10, "type": "VEC3"}] * 2),
    "nodes that double": gltf_of(3, nodes=[*({"children": [n, n]} for n in range(1, 60)), {"mesh": 0}]),
    "a mesh for a million primitives": gltf_of(
        3, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}] * 50_000}], nodes=[{"mesh": 0}] * 1000
    ),
}


@pytest.mark.parametrize("name", GLTFS)
def test_a_gltf_that_claims_what_it_has_not_is_one_message(tmp_path, name):
    def fault(_, target, __):
        if TRIANGLES in target:
            return Fault(400, b"{}")
        return Fault(body=GLTFS[name]) if GLTF in target else None

    with OnshapeServer(desk(), fault=fault) as server:
        url = f"source.url='{server.document_url()}'"
        output_text = limited(tmp_path, "source=onshape", url, **server.environ)
        assert "(400)" in output_text or "glTF" in output_text


@pytest.mark.parametrize("name", GLTFS)
def test_a_gltf_of_a_robots_own_file_is_one_message(tmp_path, name):
    (tmp_path / "mesh.gltf").write_bytes(GLTFS[name])
    mesh = '<visual><geometry><mesh filename="mesh.gltf"/></geometry></visual>'
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm"><link name="base">{mesh}</link></robot>')
    output_text = limited(tmp_path, "source=urdf", "source.path=arm.urdf")
    assert "E-MESH-READ" in output_text
    assert "mesh.gltf" in output_text


def test_a_robot_of_aliases_is_one_message(tmp_path):
    lines = [f"  {b}: &{b} [{', '.join([f'*{a}'] * 10)}]" for a, b in zip("abcdefgh", "bcdefghi")]
    text = "\n".join(["# @package _global_", "vars:", "  a: &a [1]", *lines, ""])
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "arm.yaml").write_text(text)
    assert "aliases" in limited(tmp_path, "robot=arm")
