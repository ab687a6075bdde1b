"""The images of a URDF's meshes: where they are found, which are carried, and what is said of the others."""

import base64
import json
import os
import struct
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from linkwright.stages.fetch import fetch
from linkwright.stages.fetch.bundle.archive import pack, read
from linkwright.stages.fetch.source import FetchContext
from linkwright.stages.fetch.urdf.gather import gather
from linkwright.stages.fetch.urdf.section import UrdfSourceSection
from linkwright.stages.fetch.urdf.source import UrdfSource
from linkwright.stages.fetch.urdf.survey import identity
from linkwright.stages.formats import png, triangles
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.errors import Diagnostic, SourceError
from tests.support.building import plan_of
from tests.support.textures import Corners, chunk, cube, image, obj, ordered, put, urdf, visual

MTL = b"newmtl m\nmap_Kd four.png\n"
JPEG = b"\xff\xd8\xff\xe0" + bytes(60)


def gathered(folder: Path, *visuals: str, **files: bytes) -> tuple[Bundle, tuple[Diagnostic, ...]]:
    given = {"robot.urdf": urdf(*(visuals or [visual("cube.obj")])), "cube.obj": obj(cube()), "m.mtl": MTL}
    put(folder, **given | files)
    return gather(UrdfSourceSection(path=str(folder / "robot.urdf")), {})


def only_body(bundle: Bundle) -> triangles.Body:
    (digest,) = [digest for request, digest in bundle.requests.items() if request.startswith("mesh/")]
    (body,) = triangles.decode(bundle.blobs[digest]).values()
    return body


def corners(body: triangles.Body) -> Corners:
    assert body.texcoords is not None
    return np.concatenate([body.points[body.triangles], body.texcoords], axis=-1)


def images(bundle: Bundle) -> dict[str, bytes]:
    return {
        request: bundle.blobs[digest]
        for request, digest in bundle.requests.items()
        if request.startswith("image/")
    }


def test_a_bundle_has_each_image_once_by_its_content(tmp_path: Path) -> None:
    bundle, found = gathered(
        tmp_path, visual("cube.obj"), visual("cube.obj", "2 2 2"), **{"four.png": image()}
    )
    digest = sha256(image()).hexdigest()
    assert (found, images(bundle)) == ((), {f"image/{digest}": image()})
    for request, blob in bundle.requests.items():
        if request.startswith("mesh/"):
            (body,) = triangles.decode(bundle.blobs[blob]).values()
            assert (body.palette, body.textures) == (((1.0, 1.0, 1.0, 1.0),), (digest,))
            assert triangles.textures(bundle.blobs[blob]) == {digest}


def test_another_image_is_another_robot(tmp_path: Path) -> None:
    made = []
    for name, picture in (("a", image()), ("b", image()), ("c", image(8))):
        bundle, _ = gathered(tmp_path / name, **{"four.png": picture})
        keys = UrdfSourceSection(path=str(tmp_path / name / "robot.urdf"))
        made.append((json.dumps(identity(keys, {})), bundle.root["microversion"]))
    assert made[0] == made[1]
    assert not set(made[0]) & set(made[2])


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("four.png", "meshes/four.png"),
        ("../textures/four.png", "textures/four.png"),
        ("..\\textures\\four.png", "textures/four.png"),
        ("my four.png", "meshes/my four.png"),
        ("four%20.png", "meshes/four .png"),
    ],
)
def test_images_are_found_in_the_robots_folders(tmp_path: Path, name: str, place: str) -> None:
    files = {"meshes/cube.obj": obj(cube()), "meshes/m.mtl": f"newmtl m\nmap_Kd {name}\n".encode()}
    bundle, found = gathered(tmp_path, visual("meshes/cube.obj"), **files, **{place: image()})
    assert (found, list(images(bundle).values())) == ((), [image()])


def test_an_image_may_lie_beside_the_library_that_names_it(tmp_path: Path) -> None:
    files = {"cube.obj": obj(cube(), library="look/m.mtl"), "look/m.mtl": MTL, "look/four.png": image()}
    assert len(images(gathered(tmp_path, **files)[0])) == 1


def broken() -> dict[str, tuple[bytes | None, str]]:
    good = image()
    header = struct.pack(">IIBBBBB", 1 << 15, 1 << 15, 8, 2, 0, 0, 0)
    huge = png.SIGNATURE + chunk(b"IHDR", header) + chunk(b"IDAT", b"") + chunk(b"IEND", b"")
    wrong = png.SIGNATURE + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 4, 7, 2, 0, 0, 0)) + good[33:]
    return {
        "missing": (None, "there is no such file"),
        "jpeg": (JPEG, "it is a JPEG, and only PNG images are carried"),
        "text": (b"hello", "it is not a PNG"),
        "empty": (b"", "it is not a PNG"),
        "cut": (good[:-5], "it is incomplete"),
        "long": (png.SIGNATURE + b"\xff" * 40, "it is incomplete"),
        "damaged": (good[:45] + bytes([good[45] ^ 1]) + good[46:], "it is damaged"),
        "headless": (png.SIGNATURE + good[33:], "it is damaged: it does not begin with its header"),
        "impossible": (wrong, "it is damaged: its header is invalid"),
        "bodiless": (good[:33] + chunk(b"IEND", b""), "it is damaged: its pixels are incomplete"),
        "huge": (huge, "it has 32768 × 32768 pixels; at most 67108864 are carried"),
    }


@pytest.mark.parametrize("case", broken())
def test_an_image_that_cannot_be_used_is_named_and_the_colour_stays(tmp_path: Path, case: str) -> None:
    data, why = broken()[case]
    mtl = b"newmtl m\nKd 1 0 0\nmap_Kd four.png\n"
    bundle, found = gathered(tmp_path, **{"m.mtl": mtl}, **({} if data is None else {"four.png": data}))
    assert [(one.code, one.level) for one in found] == [("W-TEXTURE", "warning")]
    assert found[0].message == f"the texture four.png of cube.obj is left out: {why}"
    body = only_body(bundle)
    assert (body.palette, body.textures, body.texcoords) == (((1.0, 0.0, 0.0, 1.0),), (), None)
    assert images(bundle) == {}


def test_an_image_outside_of_the_robots_folders_or_that_is_a_pipe_is_not_read(tmp_path: Path) -> None:
    put(tmp_path, **{"secret.png": image()})
    _, found = gathered(tmp_path / "arm", **{"m.mtl": b"newmtl m\nmap_Kd ../secret.png\n"})
    assert "outside of the robot's folders" in found[0].message
    (tmp_path / "arm" / "link.png").symlink_to(tmp_path / "secret.png")
    _, found = gathered(tmp_path / "arm", **{"m.mtl": b"newmtl m\nmap_Kd link.png\n"})
    assert "outside of the robot's folders" in found[0].message
    os.mkfifo(tmp_path / "arm" / "pipe.png")
    _, found = gathered(tmp_path / "arm", **{"m.mtl": b"newmtl m\nmap_Kd pipe.png\n"})
    assert [one.code for one in found] == ["W-TEXTURE"]


def test_images_are_bounded_in_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(png, "LARGEST", 50)
    _, found = gathered(tmp_path, **{"four.png": image()})
    assert f"it has {len(image())} bytes, more than is read" in found[0].message


def test_a_mesh_without_coordinates_has_no_texture(tmp_path: Path) -> None:
    plain = (
        b"mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    bundle, found = gathered(tmp_path, **{"cube.obj": plain, "four.png": image()})
    assert "the mesh has no texture coordinates" in found[0].message
    assert images(bundle) == {}


def test_options_of_an_image_are_not_supported(tmp_path: Path) -> None:
    mtl = b"newmtl m\nmap_Kd -s 2 2 2 four.png\n"
    _, found = gathered(tmp_path, **{"m.mtl": mtl, "four.png": image()})
    assert found[0].message.endswith("its options (-s 2 2 2) are not supported")


# The robot's own materials.

PAINTED = '<material name="x"><color rgba="1 0 0 1"/><texture filename="{}"/></material>'


def test_a_material_of_the_urdf_gives_a_mesh_its_image(tmp_path: Path) -> None:
    plain = obj(cube()).replace(b"mtllib m.mtl\n", b"")
    inside = PAINTED.format("package://robot/four.png")
    files = {"robot/meshes/cube.obj": plain, "robot/four.png": image(), "robot/package.xml": b""}
    bundle, found = gathered(tmp_path, visual("package://robot/meshes/cube.obj", inside=inside), **files)
    body = only_body(bundle)
    assert (found, body.palette) == ((), ((1.0, 0.0, 0.0, 1.0),))
    assert body.textures == (sha256(image()).hexdigest(),)
    assert np.allclose(ordered(corners(body)), ordered(cube()))


def test_the_urdfs_image_wins_and_where_it_is_missing_the_meshs_own_stays(tmp_path: Path) -> None:
    other = image(8)
    seen = visual("cube.obj", inside=PAINTED.format("other.png"))
    bundle, found = gathered(tmp_path, seen, **{"four.png": image()})
    assert [one.message for one in found] == [
        "the texture other.png of cube.obj is left out: "
        "there is no such file, and no file of that name in the robot's folder"
    ]
    assert list(images(bundle).values()) == [image()]
    bundle, found = gathered(tmp_path, seen, **{"other.png": other})
    assert (found, list(images(bundle).values())) == ((), [other])


def test_the_urdfs_colour_is_for_what_has_no_image(tmp_path: Path) -> None:
    lines = obj(cube()).decode().splitlines()
    lines.insert(-3, "usemtl plain")
    files = {"cube.obj": "\n".join(lines).encode(), "four.png": image()}
    mtl = MTL + b"newmtl plain\nKd 0 1 0\n"
    red = '<material name="x"><color rgba="1 0 0 1"/></material>'
    bundle, _ = gathered(tmp_path, visual("cube.obj", inside=red), **files, **{"m.mtl": mtl})
    body = only_body(bundle)
    assert body.palette == ((1.0, 0.0, 0.0, 1.0), (1.0, 1.0, 1.0, 1.0))
    assert body.textures == ("", sha256(image()).hexdigest())
    assert np.bincount(body.colours).tolist() == [3, 9]


def test_where_an_image_lies_is_not_told(tmp_path: Path) -> None:
    far = put(tmp_path / "far", **{"four.png": image()}) / "four.png"
    bundle, found = gathered(tmp_path / "here", visual("cube.obj", inside=PAINTED.format(f"file://{far}")))
    assert [one.code for one in found] == ["W-TEXTURE"]  # the mesh's own, which is missing
    assert len(images(bundle)) == 1
    assert not [blob for blob in bundle.blobs.values() if str(tmp_path).encode() in blob]


def test_a_collision_has_no_image(tmp_path: Path) -> None:
    text = urdf(visual("cube.obj")).replace(b"visual>", b"collision>")
    bundle, found = gathered(tmp_path, **{"robot.urdf": text, "four.png": image()})
    assert (found, images(bundle), only_body(bundle).textures) == ((), {}, ())


# glTF: its v points downwards.


def gltf(corners: Corners, **changes: Any) -> tuple[dict[str, Any], bytes]:
    """A glTF of loose triangles with a texture, and its buffer."""
    points = corners[..., :3].reshape(-1, 3).astype("<f4")
    pairs = (corners[..., 3:].reshape(-1, 2) * [1, -1] + [0, 1]).astype("<f4")
    buffer = points.tobytes() + pairs.tobytes()
    size, count = len(points.tobytes()), len(points)
    tree = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "four.png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": count, "type": "VEC2"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": size},
            {"buffer": 0, "byteOffset": size, "byteLength": len(buffer) - size},
        ],
        "buffers": [{"uri": "a.bin", "byteLength": len(buffer)}],
    }
    return {**tree, **changes}, buffer


def glb(tree: dict[str, Any], buffer: bytes) -> bytes:
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    buffer += bytes(-len(buffer) % 4)
    body = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def in_the_buffer(place: str) -> tuple[dict[str, Any], bytes]:
    """A glTF whose image is in its buffer."""
    tree, buffer = gltf(cube())
    view = {"buffer": 0, "byteOffset": len(buffer), "byteLength": len(image())}
    buffer += image()
    record = {"byteLength": len(buffer), **({"uri": place} if place else {})}
    images = [{"bufferView": 2, "mimeType": "image/png"}]
    return {
        **tree,
        "bufferViews": [*tree["bufferViews"], view],
        "images": images,
        "buffers": [record],
    }, buffer


def as_data(data: bytes) -> str:
    return f"data:application/octet-stream;base64,{base64.b64encode(data).decode()}"


def gltf_files() -> dict[str, dict[str, bytes]]:
    tree, buffer = gltf(cube())
    inside = {**tree, "images": [{"uri": as_data(image())}], "buffers": [{"byteLength": len(buffer)}]}
    beside = {**tree, "buffers": [{"byteLength": len(buffer)}]}
    second = json.loads(json.dumps(tree).replace("TEXCOORD_0", "TEXCOORD_1"))
    second["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1
    return {
        "files beside a gltf": {"a.gltf": json.dumps(tree).encode(), "a.bin": buffer, "four.png": image()},
        "an image beside a glb": {"a.glb": glb(beside, buffer), "four.png": image()},
        "an image as text": {"a.glb": glb(inside, buffer)},
        "an image in a glb": {"a.glb": glb(*in_the_buffer(""))},
        "an image in a buffer": {
            "a.gltf": json.dumps(in_the_buffer("a.bin")[0]).encode(),
            "a.bin": in_the_buffer("a.bin")[1],
        },
        "second coordinates": {"a.gltf": json.dumps(second).encode(), "a.bin": buffer, "four.png": image()},
    }


@pytest.mark.parametrize("case", gltf_files())
def test_textures_of_a_gltf(tmp_path: Path, case: str) -> None:
    files = gltf_files()[case]
    (name,) = [name for name in files if name.startswith("a.gl")]
    bundle, found = gathered(tmp_path, visual(name), **files)
    body = only_body(bundle)
    assert (found, list(images(bundle).values())) == ((), [image()])
    assert (body.palette, body.textures) == (((1.0, 1.0, 1.0, 1.0),), (sha256(image()).hexdigest(),))
    assert np.allclose(ordered(corners(body)), ordered(cube()), atol=2e-6)


def odd_gltfs() -> dict[str, tuple[dict[str, Any], str]]:
    moved = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}
    tree, _ = gltf(cube())
    return {
        "moved": (
            {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": moved}}]},
            "it is moved by KHR_texture_transform, which is not supported",
        ),
        "not base64": ({"images": [{"uri": "data:image/png;base64,%%%"}]}, "it is damaged"),
        "no base64": ({"images": [{"uri": "data:image/png,abc"}]}, "it is damaged"),
        "nothing": ({"images": [{}]}, "it is damaged"),
        "jpeg": ({"images": [{"uri": as_data(JPEG), "name": "photo"}]}, "it is a JPEG"),
        "no such view": ({"images": [{"bufferView": 9}]}, "it is damaged"),
        "no coordinates": (
            {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]},
            "the mesh has no texture coordinates",
        ),
        "coordinates of integers": (
            {"accessors": [tree["accessors"][0], {**tree["accessors"][1], "componentType": 5123}]},
            "the mesh has no texture coordinates",
        ),
    }


@pytest.mark.parametrize("case", odd_gltfs())
def test_a_texture_of_a_gltf_that_cannot_be_used_is_named(tmp_path: Path, case: str) -> None:
    changes, why = odd_gltfs()[case]
    tree, buffer = gltf(cube(), **changes)
    files = {"a.gltf": json.dumps(tree).encode(), "a.bin": buffer, "four.png": image()}
    bundle, found = gathered(tmp_path, visual("a.gltf"), **files)
    assert [one.code for one in found] == ["W-TEXTURE"]
    assert f"of a.gltf is left out: {why}" in found[0].message
    assert (images(bundle), only_body(bundle).textures) == ({}, ())


@pytest.mark.parametrize(
    "changes",
    [
        {"textures": [{"source": "zero"}]},
        {"textures": [{"source": 7}]},
        {"textures": [{"source": -1}]},
        {"textures": []},
        {"textures": None},
        {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": 5}}]},
    ],
)
def test_a_texture_in_a_form_that_is_not_known_is_none(tmp_path: Path, changes: dict[str, Any]) -> None:
    tree, buffer = gltf(cube(), **changes)
    files = {"a.gltf": json.dumps(tree).encode(), "a.bin": buffer, "four.png": image()}
    bundle, found = gathered(tmp_path, visual("a.gltf"), **files)
    assert [one.code for one in found] == ["I-URDF-TEXTURE"]
    assert (images(bundle), len(only_body(bundle).triangles)) == ({}, 12)


# Bundles.


def test_a_bundle_in_a_zip_has_the_images(tmp_path: Path) -> None:
    bundle, _ = gathered(tmp_path, **{"four.png": image()})
    (tmp_path / "r.zip").write_bytes(pack(bundle))
    plan = plan_of(source={"kind": "bundle", "path": str(tmp_path / "r.zip")})
    again = fetch(plan, FetchContext(replies=None, environ={})).bundle  # type: ignore[arg-type]
    assert (again.requests, dict(again.blobs)) == (bundle.requests, dict(bundle.blobs))


@pytest.mark.parametrize("lacking", [True, False])
def test_a_bundle_without_a_sound_image_is_refused(tmp_path: Path, lacking: bool) -> None:
    bundle, _ = gathered(tmp_path, **{"four.png": image()})
    bad = b"no image"
    requests = {**bundle.requests, "image/bad": sha256(bad).hexdigest()}
    if lacking:
        requests = {name: digest for name, digest in bundle.requests.items() if name[:6] != "image/"}
    blobs = {
        digest: {**bundle.blobs, requests.get("image/bad", ""): bad}[digest] for digest in requests.values()
    }
    changed = type(bundle)(bundle.kind, bundle.root, bundle.definition, requests, blobs)
    recording = read(pack(changed), "r.zip")
    with pytest.raises(SourceError, match="it lacks the image" if lacking else "an image: it is not a PNG"):
        UrdfSource.replay(recording, "r.zip")
