"""A message quotes nothing of a file that does not parse, whatever names the file."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from tests.support.command import called, environment
from tests.support.users import URL

SECRET = "hunter2"
"""Its letters, or a part of them, are in no message of ours."""

SHAPES: Mapping[str, bytes] = {
    name: text.replace("@", SECRET).encode()
    for name, text in {
        "users": "root:@:19000:0:99999:7:::\n@:x:0:0\n",
        "settings": "[@]\nkey = @\npassword=@\n",
        "a private key": "-----BEGIN @ KEY-----\n@\n-----END @ KEY-----\n",
        "words": "@ @ @\n@: @\n",
        "a key twice": "@: 1\n@: 2\n",
        "an open list": "x: [@, @\n",
        "an open mapping": "{@: @\n",
        "an open quote": "a: '@\n",
        "an open double quote": 'a: "@\\q"\n',
        "an alias": "a: *@\n",
        "an anchor twice": "a: &@ &@ 1\n",
        "a tag": "a: !@ x\n",
        "a tag of a handle": "a: !@!x y\n",
        "a directive": "%@ 1\n---\n",
        "a tab": "a:\n\t- @\n",
        "two colons": "a: @: @\n",
        "a bad character": "a: `@\n",
        "a control character": "a: @\x01@\n",
        "two documents": "a: @\n---\nb: @\n",
        "an open element": "<@",
        "an open attribute": "<a @=",
        "an unquoted value": "<a b=@>",
        "elements that do not match": "<robot><@></robot>",
        "an end too many": "<robot></robot></@>",
        "an element that is not closed": "<robot><link name='x'><@>",
        "an attribute twice": "<robot @='1' @='2'/>",
        "an entity": "<robot name='&@;'/>",
        "an entity in a text": "<robot>&@;</robot>",
        "entities": "<!DOCTYPE a [<!ENTITY x '@'>]><a>&x;</a>",
        "a comment": "<robot><!-- @",
        "a section": "<robot><![CDATA[ @",
        "an instruction": "<?@ @",
        "an encoding": "<?xml version='1.0' encoding='@'?><robot/>",
        "a version": "<?xml version='@'?><robot/>",
        "text behind": "<robot/>@",
        "a control character in XML": "<robot>@\x01</robot>",
        "JSON": '{"@": "@", ',
        "JSON with a bad value": '{"a": @}',
        "points": "v @ 1 2\nf @ 1 2\n",
        "a solid": "solid @\nfacet normal @ 0 0\nouter loop\nvertex @ 0 0\n",
        "PLY": "ply\nformat ascii 1.0\nelement @ 3\nproperty @ x\nend_header\n@\n",
        "USD": '#usda 1.0\ndef @ "@" {\n',
        "an image": "P6\n@ @\n",
    }.items()
} | {
    "no text": b"a: \xff\xfe" + SECRET.encode(),
    "an image's head": b"\x89PNG\r\n\x1a\n" + SECRET.encode() * 4,
}  # fmt: skip
"""What a file may hold that is not ours to show."""

HEAD = "# @package _global_\ndefaults:\n  - override /source: {}\n"
SAMPLE = HEAD.format("sample")


def put(here, path, text):
    file = here / path
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)


def link(path, *more):
    """The way of a link in a folder of the configuration."""

    def way(here, secret):
        put(here, "robot/good.yaml", SAMPLE)
        (here / path).parent.mkdir(parents=True, exist_ok=True)
        (here / path).symlink_to(secret)
        return ["until=graph", *more]

    return way


def source(kind, suffix):
    """The way of `source.path`."""

    def way(here, secret):
        named = here / f"named{suffix}"
        named.symlink_to(secret)
        put(here, "robot/mine.yaml", f"{HEAD.format(kind)}source: {{path: {named.name}}}\n")
        return ["robot=mine", "until=graph"]

    return way


def in_urdf(tag, suffix):
    """The way of a file that a URDF names."""

    def way(here, secret):
        named = here / f"named{suffix}"
        named.symlink_to(secret)
        shape = named.name if tag == "mesh" else "box.obj"
        mesh = f'<visual><geometry><mesh filename="{shape}"/></geometry>'
        paint = (
            f'<material name="m"><texture filename="{named.name}"/></material>' if tag == "texture" else ""
        )
        put(here, "box.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        put(here, "arm.urdf", f'<robot name="a"><link name="l">{mesh}{paint}</visual></link></robot>')
        return ["source=urdf", "source.path=arm.urdf", "until=mesh", "mesh=hull"]

    return way


def in_mjcf(text):
    """The way of a file that an MJCF names."""

    def way(here, secret):
        suffix = text.partition("named")[2].partition('"')[0]
        (here / f"named{suffix}").symlink_to(secret)
        put(here, "arm.xml", f"<mujoco>{text}</mujoco>")
        return ["source=mjcf", "source.path=arm.xml", "until=mesh", "mesh=hull"]

    return way


def checked(name):
    """The way of `linkwright check`."""

    def way(here, secret):
        (here / name).symlink_to(secret)
        return ["check", name]

    return way


def checked_with(way):
    """The way of a file that a checked file names."""

    def both(here, secret):
        way(here, secret)
        return ["check", "arm.urdf" if (here / "arm.urdf").exists() else "arm.xml"]

    return both


def element(here, secret):
    elements = f"elements: {{x: {{file: {secret}, formats: [mjcf], into: {{tag: worldbody}}}}}}\n"
    put(here, "robot/mine.yaml", SAMPLE + elements)
    return ["robot=mine", "until=graph"]


def environment_file(here, secret):
    (here / ".env").symlink_to(secret)
    return ["source=onshape", f"source.url='{URL}'"]


def compared(here, secret):
    (here / "robot.json").symlink_to(secret)
    return ["diff", "robot.json", "robot.json"]


def baseline(here, secret):
    put(here, "arm.urdf", '<robot name="a"><link name="l"/></robot>')
    return ["check", "arm.urdf", "--baseline", str(secret)]


MJCF_MESH = (
    '<asset><mesh name="m" file="named{}"/></asset><worldbody><geom type="mesh" mesh="m"/></worldbody>'
)
MJCF_TEXTURE = '<asset><texture name="t" type="2d" file="named.png"/></asset>'
WAYS: Mapping[str, Callable[[Path, Path], list[str]]] = {
    "a robot": link("robot/mine.yaml", "robot=mine"),
    "a robot by its path": link("x/mine.yaml", "robot=x/mine.yaml"),
    "a part of a robot": lambda here, secret: (
        put(here, "robot/mine.yaml", SAMPLE.replace("  - o", "  - part\n  - o"))
        or link("robot/part.yaml", "robot=mine")(here, secret)
    ),
    "an experiment": link("experiment/mine.yaml", "robot=good", "experiment=mine"),
    "an option": link("mesh/mine.yaml", "robot=good", "mesh=mine"),
    "a motor": link("motors/mine.yaml", "robot=good", "actuators.hip.motor=mine"),
    "elements": element,
    "source urdf": source("urdf", ".urdf"),
    "source urdf, any name": source("urdf", ""),
    "source mjcf": source("mjcf", ".xml"),
    "source bundle": source("bundle", ".zip"),
    **{f"a mesh {end}": in_urdf("mesh", end) for end in (".obj", ".stl", ".dae", ".ply", ".gltf", ".glb")},
    **{f"a texture {end}": in_urdf("texture", end) for end in (".png", ".jpg")},
    "an include": in_mjcf('<include file="named.xml"/>'),
    **{f"an MJCF mesh {end}": in_mjcf(MJCF_MESH.format(end)) for end in (".obj", ".stl", ".msh")},
    "an MJCF texture": in_mjcf(MJCF_TEXTURE),
    "an MJCF height field": in_mjcf('<asset><hfield name="h" size="1 1 1 1" file="named.png"/></asset>'),
    **{f"check {name}": checked(name) for name in ("a.urdf", "a.xml", "a.sdf", "a.usda", "robot.json")},
    **{
        f"check of a mesh {end}": checked_with(in_urdf("mesh", end))
        for end in (".obj", ".stl", ".dae", ".ply", ".gltf")
    },
    "check of a texture": checked_with(in_urdf("texture", ".png")),
    "check of an include": checked_with(in_mjcf('<include file="named.xml"/>')),
    "check of an MJCF texture": checked_with(in_mjcf(MJCF_TEXTURE)),
    "diff": compared,
    "a baseline": baseline,
    ".env": environment_file,
}  # fmt: skip


def shown(here, way, shape):
    """All that a command says, and leaves behind, about a secret of a shape."""
    here.mkdir()
    secret = here.parent / "id_rsa"
    secret.write_bytes(SHAPES[shape])
    arguments = WAYS[way](here, secret)
    done = called(here, *arguments, environ=environment(here.parent, seeded=False))
    left = [file.read_bytes().decode(errors="replace") for file in here.rglob("*") if file.is_file()
            and file.name in ("report.json", "report.html", "build.log")]  # fmt: skip
    return "\n".join([done.stdout, done.stderr, *left])


YAML = [way for way in WAYS if way == "a motor" or way.startswith(("a robot", "a part", "an exp", "an opt"))]

PARSES = {(way, "JSON with a bad value") for way in YAML}
"""Ways in by YAML, which is the user's robot."""

FAST = {
    "a robot": "a key twice", "a motor": "an open list", "elements": "elements that do not match",
    "source urdf": "an attribute twice", "an include": "an open element", "a mesh .ply": "PLY",
}  # fmt: skip


@pytest.mark.parametrize(("way", "shape"), FAST.items())
def test_a_message_quotes_nothing_of_a_file_that_does_not_parse(tmp_path, way, shape):
    text = shown(tmp_path / "here", way, shape)
    assert "unter" not in text
    assert "bug in linkwright" not in text


@pytest.mark.slow
@pytest.mark.usefixtures("guests_at_home")
@pytest.mark.parametrize("way", WAYS)
def test_nor_of_any_other(tmp_path, way):
    """What guests say comes from a process of their own in the tests above."""
    leaks = {}
    for number, shape in enumerate(SHAPES):
        if (way, shape) not in PARSES:
            (tmp_path / str(number)).mkdir()
            text = shown(tmp_path / str(number) / "here", way, shape)
            leaks[shape] = re.findall(".*(?:unter|bug in linkwright).*", text)[:3]
    assert not any(leaks.values()), leaks
