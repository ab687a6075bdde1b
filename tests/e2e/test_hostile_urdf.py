"""Files that are no robots, or mean harm: one clear error each, at once."""

import resource
import struct
from pathlib import Path

import pytest

from tests.support.cases import mostly_slow
from tests.support.command import called, tree

ENTITIES = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 12))
LAUGHS = f'<!DOCTYPE r [<!ENTITY l0 "lol">{ENTITIES}]>'
EXTERNAL = '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]>'
XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
ENDLESS = '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>'
LIMIT = 6.0
"""What one of these may take of a processor [s], with the imports of a first build."""


def robot(body, name="r", before="", more=""):
    return f'{before}<robot name="{name}" {more}>{body}</robot>'


def meshed(name):
    shape = f'<geometry><mesh filename="{name}"/></geometry>'
    return robot(f'<link name="a"><collision>{shape}</collision></link>')


def timed(here, name):
    """The message of the command on a file, which it refuses in time; nothing is left."""
    before, start = tree(here), _spent()
    trusted = ["source.trust=true"] if name.endswith(".xacro") else []
    done = called(here, "source=urdf", f"source.path={name}", "until=graph", "name=r", *trusted, status=1)
    assert _spent() - start < LIMIT
    assert done.stderr.count("error:") == 1
    assert not [word for word in ("Traceback", str(here), "root:") if word in done.stdout + done.stderr]
    assert {Path(path).parts[0] for path in tree(here) - before} <= {"outputs"}
    return done.stderr


def _spent():
    """Processor time of this process and its guests so far [s]: unlike by the clock, a busy computer is not
    slow."""
    uses = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(used.ru_utime + used.ru_stime for used in uses)


DEEP = "<a>" * 10_000 + "</a>" * 10_000
BAD = '\n<link name="a"><inertial><mass value="nan"/></inertial></link>\n<link name="a"/>'
URDFS = (
    (robot("", name="&l11;", before=LAUGHS), "entities"),
    (robot("<link name='a'>&l11;</link>", before=LAUGHS), "entities"),
    (robot("<link name='a'>&x;</link>", before=EXTERNAL), "entities"),
    (robot("", name="&x;", before=EXTERNAL), "entity is external"),
    (robot(DEEP), "nested"),
    (robot("", name="a" * 50_000_000), "bytes"),
    (robot("", name="a" * 15_000_000), "10 MB"),
    ("<robot" + "<!--" * 3_000_000, "line 1"),
    (robot("<mesh filename " * 500_000), "line 1"),
    (robot("<link/>" * 300_000), "300000 elements"),
    ("", "empty"),
    (bytes(range(256)) * 1000, "not text"),
    ("once upon a time", "line 1"),
    ("<sdf/>", "<sdf>"),
)
ROBOTS = (
    (robot(BAD), "line 2", '<mass value="nan">', "line 3", 'another link is called "a"'),
    (meshed("package://p/a.stl"), "E-MESH-MISSING", "package://p/a.stl", "source.packages"),
    (meshed("/etc/passwd"), "E-MESH-READ", "passwd", "format"),
)
XACROS = (
    (robot("", name="&l11;", before=LAUGHS, more=XACRO), "r.xacro", "cannot expand it"),
    (robot(ENDLESS, more=XACRO), "call themselves"),
    (robot(DEEP, more=XACRO), "r.xacro", "too deep"),
    (robot('<link name="${1/0}"/>', more=XACRO), "r.xacro", "division by zero"),
    (robot('<link name="$(arg n)"/>', more=XACRO), "argument n", "source.args"),
)
FILES = [
    *(("r.urdf", (*row, "r.urdf")) for row in URDFS),
    *(("r.urdf", row) for row in ROBOTS),
    *(("r.xacro", row) for row in XACROS),
]


@pytest.mark.parametrize(("name", "row"), mostly_slow(FILES, keep=3), ids=lambda value: "")
def test_a_hostile_file_is_one_error_at_once(tmp_path, name, row):
    text, *words = row
    (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    message = timed(tmp_path, name)
    assert [word for word in words if word not in message] == []


PLY = """ply
format binary_little_endian 1.0
element vertex {count}
property float x
property float y
property float z
element face 1
property list uint int vertex_indices
end_header
"""
GLTF = """{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 36, "uri": "{uri}"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 36}}],
"accessors": [{{"bufferView": 0, "count": {count}, "componentType": 5126, "type": "VEC3"}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}], "nodes": [{{"mesh": 0}}],
"scenes": [{{"nodes": [0]}}]}}"""


MESHES = (
    ("a.stl", b"", "it is empty"),
    ("a.stl", bytes(80) + struct.pack("<I", 100) + bytes(500), "announces 100 triangles and contains 10"),
    ("a.stl", bytes(80) + struct.pack("<I", 2**32 - 1), "announces 4294967295 triangles"),
    ("a.stl", b"\0" * 80 + struct.pack("<I12fH", 1, *[float("nan")] * 12, 0), "NaN or infinite"),
    ("a.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "no triangles"),
    ("a.stl", b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "damaged"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n", "negative indices"),
    ("a.obj", bytes(range(256)) * 100, "no triangles"),
    ("a.ply", PLY.format(count=10**12).encode(), "announces more"),
    ("a.ply", PLY.format(count=3).encode() + bytes(36) + b"\xff" * 60, "damaged"),
    ("a.glb", b"glTF" + struct.pack("<IIII", 2, 2**32 - 1, 2**32 - 1, 0x4E4F534A) + b"{}", "mesh a.glb"),
    ("a.gltf", GLTF.format(uri="../../../etc/passwd", count=3).encode(), "damaged"),
    ("a.gltf", GLTF.format(uri="a.gltf", count=10**12).encode(), "damaged"),
    ("a.dae", f"{LAUGHS}<COLLADA>&l11;</COLLADA>".encode(), "entities"),
    ("a.dae", f"<COLLADA>{DEEP}</COLLADA>".encode(), "nested"),
    ("a.step", b"x", "stl, obj, dae"),
)


@pytest.mark.parametrize(("name", "data", "words"), mostly_slow(MESHES, keep=2), ids=lambda value: "")
def test_a_hostile_mesh_is_one_error_at_once(tmp_path, name, data, words):
    (tmp_path / "r.urdf").write_text(meshed(name))
    (tmp_path / name).write_bytes(data)
    message = timed(tmp_path, "r.urdf")
    assert "E-MESH-READ" in message
    assert words in message


@pytest.mark.parametrize("path", ["gone.urdf", "."])
def test_a_path_that_is_no_file_is_known_before_anything_is_built(tmp_path, path):
    done = called(tmp_path, "source=urdf", f"source.path={path}", "name=r", status=2)
    assert "source.path" in done.stderr
    assert tree(tmp_path) == set()
