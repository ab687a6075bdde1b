"""Faults of the Python package."""

import random

from tests.support.mutations.kind import Files, Planted
from tests.support.mutations.texts import Fault, kinds

MODULE, PROJECT, COPIES = (
    "python/*_description/__init__.py",
    "python/pyproject.toml",
    "python/*_description/*",
)

KINDS = kinds(
    "python",
    "C-PYTHON",
    Fault(
        "path of another file", MODULE, r'URDF_PATH = .*"(?P<old>\w+\.urdf)"', "arm.urdf", 'constant "URDF'
    ),
    Fault(
        "path from another folder", MODULE, r"MJCF_PATH = _path.join\((?P<old>\w+)", "_path", 'constant "MJCF'
    ),
    Fault("path gone", MODULE, r"(?P<old>SCENE_PATH = .*\n)", "", 'constant "SCENE_PATH"'),
    Fault("name not exported", MODULE, r'(?P<old>    "SRDF_PATH",\n)', "", 'constant "__all__"'),
    Fault("module imports more", MODULE, r"(?P<old>)\n__version__", "\nimport os\n", "module", "import os"),
    Fault("module not Python", MODULE, r"(?P<old>__all__ = )", "__all__ = = ", "file"),
    Fault("project renamed", PROJECT, r'\nname = "(?P<old>\w+)"', "arm", "project", "name"),
    Fault("files not in the wheel", PROJECT, r'packages = \["(?P<old>\w+)"', "arm", "tool", "packages"),
    Fault(
        "meshes left out of the wheel", PROJECT, r"ignore-vcs = (?P<old>true)", "false", "tool", "ignore-vcs"
    ),
    Fault("built by another tool", PROJECT, r'build-backend = "(?P<old>\S+)"', "flit", "build-system"),
    Fault("readme that is not there", PROJECT, r'readme = "(?P<old>\S+)"', "HELLO.md", "project", "readme"),
    Fault(
        "URDF is an old copy", f"{COPIES}/*.urdf", r'<mass value="(?P<old>[^"]+)"', "9", "link", "mass value"
    ),
    Fault(
        "MJCF is an old copy",
        f"{COPIES}/robot.xml",
        r'<body name="(?P<body>\w+)" pos="(?P<old>[^"]+)"',
        "0 0 9",
        'body "{body}"',
        "pos",
    ),
    Fault(
        "scene is an old copy",
        f"{COPIES}/scene.xml",
        r'"floor".*size="(?P<old>[^"]+)"',
        "9 9 1",
        "floor",
        "size",
    ),
    Fault("SDF is an old copy", f"{COPIES}/*.sdf", r"<mass>(?P<old>[^<]+)<", "9", "link", "mass"),
    Fault(
        "SRDF is an old copy",
        f"{COPIES}/*.srdf",
        r'reason="(?P<old>Adjacent)"',
        "Never",
        "disable_collisions",
        "reason",
    ),
    Fault(
        "robot.json is an old copy", f"{COPIES}/robot.json", r'"mass": (?P<old>[\d.]+)', "9", "links", "mass"
    ),
)


@KINDS.add("mesh gone", "C-PYTHON")
def _(files: Files, rng: random.Random) -> Planted:
    mesh = rng.choice(sorted(files.folder.glob(f"{COPIES}/assets/*.stl")))
    mesh.unlink()
    return Planted(f'file "{mesh.name}"', ("",))


@KINDS.add("mesh is an old copy", "C-PYTHON")
def _(files: Files, rng: random.Random) -> Planted:
    mesh = rng.choice(sorted(files.folder.glob(f"{COPIES}/assets/*.stl")))
    data = bytearray(mesh.read_bytes())
    data[84 + 50 * rng.randrange((len(data) - 84) // 50) + 13] ^= 0x40
    mesh.write_bytes(data)
    return Planted(f'file "{mesh.name}"', ("",))
