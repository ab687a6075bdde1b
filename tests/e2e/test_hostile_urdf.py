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

Text = str | bytes


def robot(body: str, name: str = "r", before: str = "", more: str = "") -> str:
    return f'{before}<robot name="{name}" {more}>{body}</robot>'


def meshed(name: str) -> str:
    return robot(
        f'<link name="a"><collision><geometry><mesh filename="{name}"/></geometry></collision></link>'
    )


def timed(here: Path, name: str) -> str:
    """What the command says of a file, which it refuses in time; nothing is left."""
    before = tree(here)
    start = _spent()
    trusted = ["source.trust=true"] if name.endswith(".xacro") else []
    done = called(here, "source=urdf", f"source.path={name}", "until=graph", "name=r", *trusted)
    seconds = _spent() - start
    assert done.returncode == 1, done.stdout + done.stderr
    assert done.stderr.count("error:") == 1
    assert "Traceback" not in done.stderr
    assert str(here) not in done.stdout + done.stderr
    assert "root:" not in done.stderr
    left = {Path(path).parts[0] for path in tree(here) - before}
    assert left <= {"outputs"}
    assert seconds < LIMIT
    return done.stderr


def _spent() -> float:
    """Processor time of this process and its guests so far [s]: unlike by the clock, a busy computer is not
    slow."""
    uses = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(used.ru_utime + used.ru_stime for used in uses)


@pytest.mark.parametrize(
    ("name", "text", "output_text"),
    mostly_slow(
        [
            ("r.urdf", robot("", name="&l11;", before=LAUGHS), ["r.urdf", "entities"]),
            ("r.urdf", robot("<link name='a'>&l11;</link>", before=LAUGHS), ["r.urdf", "entities"]),
            ("r.urdf", robot("<link name='a'>&x;</link>", before=EXTERNAL), ["r.urdf", "entities"]),
            ("r.urdf", robot("", name="&x;", before=EXTERNAL), ["r.urdf", "entity is external"]),
            ("r.urdf", robot("<a>" * 10_000 + "</a>" * 10_000), ["r.urdf", "nested"]),
            ("r.urdf", robot("", name="a" * 50_000_000), ["r.urdf", "bytes"]),
            ("r.urdf", robot("", name="a" * 15_000_000), ["r.urdf", "10 MB"]),
            ("r.urdf", "<robot" + "<!--" * 3_000_000, ["r.urdf", "line 1"]),
            ("r.urdf", robot("<mesh filename " * 500_000), ["r.urdf", "line 1"]),
            ("r.urdf", robot("<link/>" * 300_000), ["r.urdf", "300000 elements"]),
            ("r.urdf", "", ["r.urdf", "empty"]),
            ("r.urdf", bytes(range(256)) * 1000, ["r.urdf", "not text"]),
            ("r.urdf", "once upon a time", ["r.urdf", "line 1"]),
            ("r.urdf", "<sdf/>", ["r.urdf", "<sdf>"]),
            (
                "r.urdf",
                robot('\n<link name="a"><inertial><mass value="nan"/></inertial></link>\n<link name="a"/>'),
                ["line 2", '<mass value="nan">', "line 3", 'another link is called "a"'],
            ),
            (
                "r.urdf",
                meshed("package://p/a.stl"),
                ["E-MESH-MISSING", "package://p/a.stl", "source.packages"],
            ),
            ("r.urdf", meshed("/etc/passwd"), ["E-MESH-READ", "passwd", "format"]),
            ("r.xacro", robot("", name="&l11;", before=LAUGHS, more=XACRO), ["r.xacro", "cannot expand it"]),
            (
                "r.xacro",
                robot(ENDLESS, more=XACRO),
                ["call themselves"],
            ),
            ("r.xacro", robot("<a>" * 10_000 + "</a>" * 10_000, more=XACRO), ["r.xacro", "too deep"]),
            ("r.xacro", robot('<link name="${1/0}"/>', more=XACRO), ["r.xacro", "division by zero"]),
            ("r.xacro", robot('<link name="$(arg n)"/>', more=XACRO), ["argument n", "source.args"]),
        ],
        keep=3,
    ),
    ids=lambda value: "",
)
def test_a_hostile_file_is_one_error_at_once(
    tmp_path: Path, name: str, text: Text, output_text: list[str]
) -> None:
    (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    found = timed(tmp_path, name)
    assert [words for words in output_text if words not in found] == []


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


@pytest.mark.parametrize(
    ("name", "data", "output_text"),
    mostly_slow(
        [
            ("a.stl", b"", "it is empty"),
            (
                "a.stl",
                bytes(80) + struct.pack("<I", 100) + bytes(500),
                "announces 100 triangles and contains 10",
            ),
            ("a.stl", bytes(80) + struct.pack("<I", 2**32 - 1), "announces 4294967295 triangles"),
            ("a.stl", b"\0" * 80 + struct.pack("<I12fH", 1, *[float("nan")] * 12, 0), "NaN or infinite"),
            ("a.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "no triangles"),
            ("a.stl", b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
            ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "damaged"),
            ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n", "negative indices"),
            ("a.obj", bytes(range(256)) * 100, "no triangles"),
            ("a.ply", PLY.format(count=10**12).encode(), "announces more"),
            ("a.ply", PLY.format(count=3).encode() + bytes(36) + b"\xff" * 60, "damaged"),
            (
                "a.glb",
                b"glTF" + struct.pack("<IIII", 2, 2**32 - 1, 2**32 - 1, 0x4E4F534A) + b"{}",
                "mesh a.glb",
            ),
            ("a.gltf", GLTF.format(uri="../../../etc/passwd", count=3).encode(), "damaged"),
            ("a.gltf", GLTF.format(uri="a.gltf", count=10**12).encode(), "damaged"),
            ("a.dae", f"{LAUGHS}<COLLADA>&l11;</COLLADA>".encode(), "entities"),
            ("a.dae", b"<COLLADA>" + b"<a>" * 10_000 + b"</a>" * 10_000 + b"</COLLADA>", "nested"),
            ("a.step", b"x", "stl, obj, dae"),
        ],
        keep=2,
    ),
    ids=lambda value: "",
)
def test_a_hostile_mesh_is_one_error_at_once(
    tmp_path: Path, name: str, data: bytes, output_text: str
) -> None:
    (tmp_path / "r.urdf").write_text(meshed(name))
    (tmp_path / name).write_bytes(data)
    found = timed(tmp_path, "r.urdf")
    assert "E-MESH-READ" in found
    assert output_text in found


@pytest.mark.parametrize("path", ["gone.urdf", "."])
def test_a_path_that_is_no_file_is_known_before_anything_is_built(tmp_path: Path, path: str) -> None:
    done = called(tmp_path, "source=urdf", f"source.path={path}", "name=r")
    assert done.returncode == 2
    assert "source.path" in done.stderr
    assert tree(tmp_path) == set()
