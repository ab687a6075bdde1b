"""The images of a URDF's meshes: where they are found, which are carried, and what is said of the others."""

import base64
import json
import os
import struct
from hashlib import sha256

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
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.robot.errors import SourceError
from tests.support.building import plan_of
from tests.support.textures import chunk, cube, image, obj, ordered, put, urdf, visual

MTL = b"newmtl m\nmap_Kd four.png\n"
JPEG = b"\xff\xd8\xff\xe0" + bytes(60)


def gathered(folder, *visuals, **files):
    base = {"robot.urdf": urdf(*(visuals or [visual("cube.obj")])), "cube.obj": obj(cube()), "m.mtl": MTL}
    put(folder, **base | files)
    return gather(UrdfSourceSection(path=str(folder / "robot.urdf")), {})


def only_body(bundle):
    (digest,) = [digest for request, digest in bundle.requests.items() if request.startswith("mesh/")]
    (body,) = body_arrays.decode(bundle.blobs[digest]).values()
    return body


def corners(body):
    assert body.texcoords is not None
    return np.concatenate([body.points[body.triangles], body.texcoords], axis=-1)


def images(bundle):
    return {
        request: bundle.blobs[digest]
        for request, digest in bundle.requests.items()
        if request.startswith("image/")
    }


def test_a_bundle_has_each_image_once_by_its_content(tmp_path):
    bundle, reports = gathered(
        tmp_path, visual("cube.obj"), visual("cube.obj", "2 2 2"), **{"four.png": image()}
    )
    digest = sha256(image()).hexdigest()
    assert (reports, images(bundle)) == ((), {f"image/{digest}": image()})
    for request, blob in bundle.requests.items():
        if request.startswith("mesh/"):
            (body,) = body_arrays.decode(bundle.blobs[blob]).values()
            assert (body.palette, body.textures) == (((1.0, 1.0, 1.0, 1.0),), (digest,))
            assert triangles.textures(bundle.blobs[blob]) == {digest}


def test_another_image_is_another_robot(tmp_path):
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
def test_images_are_found_in_the_robots_folders(tmp_path, name, place):
    files = {"meshes/cube.obj": obj(cube()), "meshes/m.mtl": f"newmtl m\nmap_Kd {name}\n".encode()}
    bundle, reports = gathered(tmp_path, visual("meshes/cube.obj"), **files, **{place: image()})
    assert (reports, list(images(bundle).values())) == ((), [image()])
    # One may also lie beside the library that names it.
    files = {"cube.obj": obj(cube(), library="look/m.mtl"), "look/m.mtl": MTL, "look/four.png": image()}
    assert len(images(gathered(tmp_path / "beside", **files)[0])) == 1


def broken():
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
def test_an_unusable_image_is_named_and_the_colour_stays(tmp_path, case):
    data, why = broken()[case]
    mtl = b"newmtl m\nKd 1 0 0\nmap_Kd four.png\n"
    bundle, reports = gathered(tmp_path, **{"m.mtl": mtl}, **({} if data is None else {"four.png": data}))
    assert [(problem.code, problem.level) for problem in reports] == [("W-TEXTURE", "warning")]
    assert reports[0].message == f"the texture four.png of cube.obj is left out: {why}"
    body = only_body(bundle)
    assert (body.palette, body.textures, body.texcoords) == (((1.0, 0.0, 0.0, 1.0),), (), None)
    assert images(bundle) == {}


def test_an_image_outside_or_that_is_a_pipe_is_not_read(tmp_path):
    put(tmp_path / "arm", **{"../secret.png": image()})
    (tmp_path / "arm" / "link.png").symlink_to(tmp_path / "secret.png")
    os.mkfifo(tmp_path / "arm" / "pipe.png")
    for name, words in (("../secret.png", "outside of the robot's folders"),
                        ("link.png", "outside of the robot's folders"), ("pipe.png", "")):  # fmt: skip
        _, (problem,) = gathered(tmp_path / "arm", **{"m.mtl": f"newmtl m\nmap_Kd {name}\n".encode()})
        assert problem.code == "W-TEXTURE"
        assert words in problem.message


def test_an_image_with_options_or_without_use_is_left_out(tmp_path, monkeypatch):
    plain = (
        b"mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    for files, words in (
        ({"m.mtl": b"newmtl m\nmap_Kd -s 2 2 2 four.png\n"}, "its options (-s 2 2 2) are not supported"),
        ({"cube.obj": plain}, "the mesh has no texture coordinates"),
        ({}, f"it has {len(image())} bytes, more than is read"),
    ):
        monkeypatch.setattr(png, "MAX_BYTES", png.MAX_BYTES if files else 50)
        bundle, reports = gathered(tmp_path, **{"four.png": image()} | files)
        assert words in reports[0].message
        assert images(bundle) == {}


# The robot's own materials.

PAINTED = '<material name="x"><color rgba="1 0 0 1"/><texture filename="{}"/></material>'


def test_a_material_of_the_urdf_gives_a_mesh_its_image(tmp_path):
    plain = obj(cube()).replace(b"mtllib m.mtl\n", b"")
    inside = PAINTED.format("package://robot/four.png")
    files = {"robot/meshes/cube.obj": plain, "robot/four.png": image(), "robot/package.xml": b""}
    bundle, reports = gathered(tmp_path, visual("package://robot/meshes/cube.obj", inside=inside), **files)
    body = only_body(bundle)
    assert (reports, body.palette) == ((), ((1.0, 0.0, 0.0, 1.0),))
    assert body.textures == (sha256(image()).hexdigest(),)
    assert np.allclose(ordered(corners(body)), ordered(cube()))


def test_the_urdfs_image_wins_over_the_meshs_own(tmp_path):
    seen, why = (
        visual("cube.obj", inside=PAINTED.format("other.png")),
        "there is no such file, and no file of",
    )
    bundle, reports = gathered(tmp_path, seen, **{"four.png": image()})
    left_out = f"the texture other.png of cube.obj is left out: {why} that name in the robot's folder"
    assert [problem.message for problem in reports] == [left_out]
    assert list(images(bundle).values()) == [image()]
    bundle, reports = gathered(tmp_path, seen, **{"other.png": image(8)})
    assert (reports, list(images(bundle).values())) == ((), [image(8)])
    # A collision has no image, and where an image lies is not told.
    text = urdf(visual("cube.obj")).replace(b"visual>", b"collision>")
    bundle, reports = gathered(tmp_path, **{"robot.urdf": text})
    assert (reports, images(bundle), only_body(bundle).textures) == ((), {}, ())
    far = visual("cube.obj", inside=PAINTED.format(f"file://{tmp_path}/four.png"))
    bundle, reports = gathered(tmp_path / "here", far)
    assert [problem.code for problem in reports] == ["W-TEXTURE"]  # the mesh's own, which is missing
    assert len(images(bundle)) == 1
    assert not [blob for blob in bundle.blobs.values() if str(tmp_path).encode() in blob]


def test_the_urdfs_colour_is_for_what_has_no_image(tmp_path):
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


# glTF: its v points downwards.


def gltf(corners, **changes):
    """A glTF of loose triangles with a texture, and its buffer."""
    points = corners[..., :3].reshape(-1, 3).astype("<f4")
    pairs = (corners[..., 3:].reshape(-1, 2) * [1, -1] + [0, 1]).astype("<f4")
    buffer = points.tobytes() + pairs.tobytes()
    size, count = len(points.tobytes()), len(points)
    accessors = [
        {"bufferView": index, "componentType": 5126, "count": count, "type": kind}
        for index, kind in enumerate(("VEC3", "VEC2"))
    ]
    views = [(0, size), (size, len(buffer) - size)]
    tree = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "four.png"}],
        "accessors": accessors,
        "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": length} for at, length in views],
        "buffers": [{"uri": "a.bin", "byteLength": len(buffer)}],
    }
    return {**tree, **changes}, buffer


def glb(tree, buffer):
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    buffer += bytes(-len(buffer) % 4)
    chunks = ((b"JSON", text), (b"BIN\0", buffer))
    body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def in_the_buffer(place):
    """A glTF whose image is in its buffer."""
    tree, buffer = gltf(cube())
    view = {"buffer": 0, "byteOffset": len(buffer), "byteLength": len(image())}
    buffer += image()
    record = {"byteLength": len(buffer), **({"uri": place} if place else {})}
    images = [{"bufferView": 2, "mimeType": "image/png"}]
    views = [*tree["bufferViews"], view]
    return {**tree, "bufferViews": views, "images": images, "buffers": [record]}, buffer


def as_data(data):
    return f"data:application/octet-stream;base64,{base64.b64encode(data).decode()}"


def gltf_files():
    tree, buffer = gltf(cube())
    stored, whole = in_the_buffer("a.bin")
    inside = {**tree, "images": [{"uri": as_data(image())}], "buffers": [{"byteLength": len(buffer)}]}
    beside = {**tree, "buffers": [{"byteLength": len(buffer)}]}
    second = json.loads(json.dumps(tree).replace("TEXCOORD_0", "TEXCOORD_1"))
    second["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1
    return {
        "files beside a gltf": {"a.gltf": json.dumps(tree).encode(), "a.bin": buffer, "four.png": image()},
        "an image beside a glb": {"a.glb": glb(beside, buffer), "four.png": image()},
        "an image as text": {"a.glb": glb(inside, buffer)},
        "an image in a glb": {"a.glb": glb(*in_the_buffer(""))},
        "an image in a buffer": {"a.gltf": json.dumps(stored).encode(), "a.bin": whole},
        "second coordinates": {"a.gltf": json.dumps(second).encode(), "a.bin": buffer, "four.png": image()},
    }


@pytest.mark.parametrize("case", gltf_files())
def test_textures_of_a_gltf(tmp_path, case):
    files = gltf_files()[case]
    (name,) = [name for name in files if name.startswith("a.gl")]
    bundle, reports = gathered(tmp_path, visual(name), **files)
    body = only_body(bundle)
    assert (reports, list(images(bundle).values())) == ((), [image()])
    assert (body.palette, body.textures) == (((1.0, 1.0, 1.0, 1.0),), (sha256(image()).hexdigest(),))
    assert np.allclose(ordered(corners(body)), ordered(cube()), atol=2e-6)


def odd_gltfs():
    moved = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}
    tree, _ = gltf(cube())
    integers = [tree["accessors"][0], {**tree["accessors"][1], "componentType": 5123}]
    bare = {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]}
    changed = {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": moved}}]}
    return {
        "moved": (changed, "it is moved by KHR_texture_transform, which is not supported"),
        "not base64": ({"images": [{"uri": "data:image/png;base64,%%%"}]}, "it is damaged"),
        "no base64": ({"images": [{"uri": "data:image/png,abc"}]}, "it is damaged"),
        "nothing": ({"images": [{}]}, "it is damaged"),
        "jpeg": ({"images": [{"uri": as_data(JPEG), "name": "photo"}]}, "it is a JPEG"),
        "no such view": ({"images": [{"bufferView": 9}]}, "it is damaged"),
        "no coordinates": (bare, "the mesh has no texture coordinates"),
        "coordinates of integers": ({"accessors": integers}, "the mesh has no texture coordinates"),
    }


@pytest.mark.parametrize("case", odd_gltfs())
def test_a_texture_of_a_gltf_that_cannot_be_used_is_named(tmp_path, case):
    changes, why = odd_gltfs()[case]
    tree, buffer = gltf(cube(), **changes)
    files = {"a.gltf": json.dumps(tree).encode(), "a.bin": buffer, "four.png": image()}
    bundle, reports = gathered(tmp_path, visual("a.gltf"), **files)
    assert [problem.code for problem in reports] == ["W-TEXTURE"]
    assert f"of a.gltf is left out: {why}" in reports[0].message
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
def test_a_texture_in_a_form_that_is_not_known_is_none(tmp_path, changes):
    tree, buffer = gltf(cube(), **changes)
    files = {"a.gltf": json.dumps(tree).encode(), "a.bin": buffer, "four.png": image()}
    bundle, reports = gathered(tmp_path, visual("a.gltf"), **files)
    assert [problem.code for problem in reports] == ["I-URDF-TEXTURE"]
    assert (images(bundle), len(only_body(bundle).triangles)) == ({}, 12)


# Bundles.


def test_a_bundle_in_a_zip_has_the_images(tmp_path):
    bundle, _ = gathered(tmp_path, **{"four.png": image()})
    (tmp_path / "r.zip").write_bytes(pack(bundle))
    plan = plan_of(source={"kind": "bundle", "path": str(tmp_path / "r.zip")})
    again = fetch(plan, FetchContext(replies=None, environ={})).bundle
    assert (again.requests, dict(again.blobs)) == (bundle.requests, dict(bundle.blobs))


@pytest.mark.parametrize("lacking", [True, False])
def test_a_bundle_without_a_sound_image_is_refused(tmp_path, lacking):
    bundle, _ = gathered(tmp_path, **{"four.png": image()})
    bad = b"no image"
    requests = {**bundle.requests, "image/bad": sha256(bad).hexdigest()}
    if lacking:
        requests = {name: digest for name, digest in bundle.requests.items() if name[:6] != "image/"}
    every = {**bundle.blobs, requests.get("image/bad", ""): bad}
    blobs = {digest: every[digest] for digest in requests.values()}
    changed = type(bundle)(bundle.kind, bundle.root, bundle.definition, requests, blobs)
    recording = read(pack(changed), "r.zip")
    with pytest.raises(SourceError, match="it lacks the image" if lacking else "an image: it is not a PNG"):
        UrdfSource.replay(recording, "r.zip")
