# ruff: noqa: E501
"""Files that were written to hang, exhaust or crash what checks them: by name, the files by path (a text,
bytes, or a function that makes what is no plain file) and the path that is checked."""

import json
import os
import socket
import struct
import zlib
from pathlib import Path

BODY = '<body name="b"><joint type="hinge"/><geom size=".1"/></body>'
LINK = '<link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'


def mjcf(world=BODY, more=""):
    return f"<mujoco>{more}<worldbody>{world}</worldbody></mujoco>"


def urdf(inside):
    return f'<robot name="r">{inside}</robot>'


def mesh_of(name):
    return urdf(f'<link name="a"><visual><geometry><mesh filename="{name}"/></geometry></visual></link>')


def fifo(path):
    os.mkfifo(path)


def folder(path):
    path.mkdir()


def listener(path):
    here = Path.cwd()
    with socket.socket(socket.AF_UNIX) as server:
        os.chdir(path.parent)
        server.bind(path.name)
        os.chdir(here)


def link_to(target):
    return lambda path: path.symlink_to(target)


def sparse(size):
    def make(path):
        with path.open("wb") as file:
            file.truncate(size)

    return make


def png(width, height):
    """A PNG whose header says that it is as large, with some of its pixels."""
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(bytes(10_000_000), 9)), (b"IEND", b"")]
    rows = (
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(rows)


def bomb(use):
    """Entities of entities, a billion of them."""
    names = "".join(f'<!ENTITY e{i} "{f"&e{i - 1};" * 10}">' for i in range(1, 10))
    return f'<!DOCTYPE mujoco [<!ENTITY e0 "aaaaaaaaaa">{names}]>{use}'


def attached(depth):
    """Models in models, each in the next above twice."""
    twice = '<attach model="m" body="x" prefix="a"/><attach model="m" body="x" prefix="b"/>'
    files = {
        f"m{i}.xml": f'<mujoco><asset><model name="m" file="m{i + 1}.xml"/></asset><worldbody><body name="x">{twice}</body></worldbody></mujoco>'
        for i in range(depth)
    }
    return {
        **files,
        f"m{depth}.xml": '<mujoco><worldbody><body name="x"><geom size=".1"/></body></worldbody></mujoco>',
    }


def robot_json(**changes):
    return json.dumps(
        {"format": "linkwright-robot", "version": 1, "name": "r", "links": [], "joints": [], **changes}
    )


def links(count):
    return [{"name": f"l{i}"} for i in range(count)]


REPLICATE = '<replicate count="{}">{}</replicate>'
TRUTH = "robot.json"

ONE = {
    # MJCF.
    "nkey": {"m.xml": mjcf(more='<size nkey="2000000000"/>')},
    "nuser": {"m.xml": mjcf(more='<size nuser_geom="2000000000"/>')},
    "memory": {"m.xml": mjcf(more='<size memory="1000T"/>')},
    "njmax": {"m.xml": mjcf(more='<size njmax="2000000000" nconmax="2000000000"/>')},
    "user sensor": {"m.xml": mjcf(more='<sensor><user dim="2000000000"/></sensor>')},
    "replicate": {"m.xml": mjcf(REPLICATE.format(1_000_000_000, "<body><geom size='.1'/></body>"))},
    "replicates": {"m.xml": mjcf(REPLICATE.format(300, REPLICATE.format(300, REPLICATE.format(300, "<body><geom size='.1'/></body>"))))},
    "replicates by an include": {
        "m.xml": mjcf(REPLICATE.format(3000, '<include file="i.xml"/>')),
        "i.xml": "<mujoco>" + REPLICATE.format(3000, '<body><geom size=".1"/></body>') + "</mujoco>",
    },
    "composite": {"m.xml": mjcf('<body><composite type="cable" count="100000000 1 1" size="1"><geom type="capsule" size=".005"/></composite></body>')},
    "flexcomp": {"m.xml": mjcf('<body><flexcomp name="f" type="grid" count="300 300 300" spacing=".1 .1 .1" dim="3"/></body>')},
    "height field": {"m.xml": mjcf(more='<asset><hfield name="h" nrow="60000" ncol="60000" size="1 1 1 1"/></asset>')},
    "texture": {"m.xml": mjcf(more='<asset><texture type="2d" builtin="flat" width="100000" height="100000"/></asset>')},
    "texture of a cube": {"m.xml": mjcf(more='<asset><texture type="cube" builtin="flat" width="60000" height="60000"/></asset>')},
    "deep bodies": {"m.xml": mjcf("<body>" * 20_000 + "</body>" * 20_000)},
    "many bodies": {"m.xml": mjcf("<body/>" * 100_000)},
    "long name": {"m.xml": mjcf(f'<body name="{"a" * 30_000_000}"/>')},
    "models in models": attached(26),
    "a model in itself": {
        "m.xml": '<mujoco><asset><model name="m" file="m.xml"/></asset><worldbody><body name="x"><attach model="m" body="x" prefix="a"/></body></worldbody></mujoco>'
    },
    "models in each other": {
        "m.xml": '<mujoco><asset><model name="m" file="n.xml"/></asset><worldbody><body name="x"><attach model="m" body="x" prefix="a"/></body></worldbody></mujoco>',
        "n.xml": '<mujoco><asset><model name="m" file="m.xml"/></asset><worldbody><body name="x"><attach model="m" body="x" prefix="b"/></body></worldbody></mujoco>',
    },
    "mesh from a device": {"m.xml": mjcf(more='<asset><mesh name="m" file="/dev/zero" content_type="model/stl"/></asset>')},
    "mesh by a link to a device": {"m.xml": mjcf(more='<asset><mesh file="m.stl"/></asset>'), "m.stl": link_to("/dev/zero")},
    "mesh from a pipe": {"m.xml": mjcf(more='<asset><mesh file="m.stl"/></asset>'), "m.stl": fifo},
    "mesh from the kernel": {"m.xml": mjcf(more='<asset><mesh name="m" file="/proc/kmsg" content_type="model/stl"/></asset>')},
    "texture from a socket": {"m.xml": mjcf(more='<asset><texture type="2d" file="t.png"/></asset>'), "t.png": listener},
    "mesh of a terabyte": {"m.xml": mjcf(more='<asset><mesh file="m.stl"/></asset>'), "m.stl": sparse(1 << 40)},
    "image of 10 gigabytes": {"m.xml": mjcf(more='<asset><texture type="2d" file="t.png"/></asset>'), "t.png": png(60_000, 60_000)},
    "images in a height field": {"m.xml": mjcf(more='<asset><hfield file="t.png" size="1 1 1 1"/></asset>'), "t.png": png(60_000, 60_000)},
    "include of a pipe": {"m.xml": '<mujoco><include file="i.xml"/></mujoco>', "i.xml": fifo},
    "include of a device": {"m.xml": '<mujoco><include file="/dev/zero"/></mujoco>'},
    "include of a terabyte": {"m.xml": '<mujoco><include file="i.xml"/></mujoco>', "i.xml": sparse(1 << 40)},
    "skin from a pipe": {"m.xml": mjcf(more='<asset><skin name="s" file="s.skn"/></asset>'), "s.skn": fifo},
    "three million elements": {"m.xml": mjcf(more="<default>" + "<geom/>" * 3_000_000 + "</default>")},
    "a file of a terabyte": {"m.xml": sparse(1 << 40)},
    "a pipe": {"m.xml": fifo},
    "a socket": {"m.xml": listener},
    "a link to a device": {"m.xml": link_to("/dev/zero")},
    # URDF.
    "URDF: a pipe": {"m.urdf": fifo},
    "URDF: mesh from a device": {"m.urdf": mesh_of("/dev/zero")},
    "URDF: mesh from a pipe": {"m.urdf": mesh_of("m.stl"), "m.stl": fifo},
    "URDF: mesh by its address": {"m.urdf": mesh_of("file:///dev/zero")},
    "URDF: 220,000 links": {"m.urdf": urdf("".join(f'<link name="l{i}"/>' for i in range(220_000)))},
    "URDF: long name": {"m.urdf": urdf(f'<link name="{"a" * 9_000_000}"/>')},
    "URDF: a terabyte": {"m.urdf": sparse(1 << 40)},
}  # fmt: skip
"""Name → files, the first of which is checked. All are refused."""

BUILDS = {
    "220,000 links": {TRUTH: robot_json(links=links(220_000))},
    "deep JSON": {TRUTH: "[" * 1_000_000 + "]" * 1_000_000},
    "deep JSON in a field": {TRUTH: robot_json(links="@").replace('"@"', "[" * 200_000 + "]" * 200_000)},
    "null for links": {TRUTH: robot_json(links=[None])},
    "null for a robot": {TRUTH: "[null]"},
    "a number beyond any": {TRUTH: robot_json(version=1, links=[{"name": "a", "mass": "@"}]).replace('"@"', "9" * 4000)},
    "no UTF-8": {TRUTH: b"\xff\xfe\x00\xff"},
    "null bytes": {TRUTH: b"\0" * 1000},
    "a folder": {TRUTH: folder},
    "a pipe": {TRUTH: fifo},
    "a link to a device": {TRUTH: link_to("/dev/zero")},
    "a terabyte": {TRUTH: sparse(1 << 40)},
    "a way out": {TRUTH: robot_json(name="../../etc/passwd", links=[{"name": "a"}])},
}  # fmt: skip
"""Folders whose robot.json is hostile. All are refused."""

BESIDE = {
    "{}.urdf": fifo,
    "{}.sdf": fifo,
    "{}.srdf": link_to("/dev/zero"),
    "{}.usda": fifo,
    "{}.xml": listener,
    "scene.xml": sparse(1 << 40),
    "model.config": fifo,
    "assets/more.stl": link_to("/dev/zero"),
    "ros2/package.xml": fifo,
}
"""By path, what takes the place of a file of a finished build. All are refused."""

ANSWERED = {
    "entities in an attribute": {"m.xml": bomb('<mujoco model="&e9;"/>')},
    "entities in a text": {"m.urdf": bomb('<robot name="r">&e9;</robot>')},
    "an include of itself": {"m.xml": '<mujoco><include file="m.xml"/></mujoco>'},
    "includes of each other": {"m.xml": '<mujoco><include file="n.xml"/></mujoco>', "n.xml": '<mujoco><include file="m.xml"/></mujoco>'},
    "null bytes": {"m.xml": b"<mujoco>\0\0\0</mujoco>"},
    "no UTF-8": {"m.urdf": b'<robot name="\xff\xfe"/>'},
    "nothing": {"m.xml": ""},
    "a folder as mesh": {"m.urdf": mesh_of("m.stl"), "m.stl": folder},
    "a number that is none": {"m.urdf": urdf(LINK.replace('"1"', '"nan"'))},
    "infinite numbers": {"m.xml": mjcf('<body pos="inf nan 1e999"><joint/><geom size="1e300"/></body>')},
    "deep links": {"m.urdf": urdf("<link>" * 5000 + "</link>" * 5000)},
    "a cycle of joints": {"m.urdf": urdf(LINK + LINK.replace('"a"', '"b"') + "".join(f'<joint name="{p}" type="fixed"><parent link="{p}"/><child link="{c}"/></joint>' for p, c in ("ab", "ba")))},
    "steps without end": {"m.xml": mjcf(more='<option timestep="1e-12"/>')},
    "a file name of 100,000 letters": {"m.urdf": mesh_of("m" * 100_000)},
    "a null byte in a file name": {"m.urdf": mesh_of("&#1;m.stl")},
    "a mesh that says more than it has": {"m.xml": mjcf(more='<asset><mesh file="m.stl"/></asset>'), "m.stl": bytes(80) + b"\xff\xff\xff\xff"},
    "a skin that says more than it has": {"m.xml": mjcf(more='<asset><skin name="s" file="s.skn"/></asset>'), "s.skn": b"\xff\xff\xff\x7f" * 8},
}  # fmt: skip
"""What may be refused, or be checked and fail: within the same limits, and without a traceback."""
