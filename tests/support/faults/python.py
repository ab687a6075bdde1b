"""Faults of a build's Python package."""

from tests.support.faults.edits import file_of, text
from tests.support.faults.fault import table

PACKAGE = "python/*_description"
MODULE, PROJECT, MESHES = f"{PACKAGE}/__init__.py", "python/pyproject.toml", f"{PACKAGE}/*/assets/*.stl"


def mesh_gone(files, rng):
    mesh = file_of(files.folder, MESHES, rng)
    mesh.unlink()
    return f'file "{mesh.name}"'


def mesh_changed(files, rng):
    mesh = file_of(files.folder, MESHES, rng)
    data = bytearray(mesh.read_bytes())
    data[84 + 50 * rng.randrange((len(data) - 84) // 50) + 13] ^= 0x40
    mesh.write_bytes(data)
    return f'file "{mesh.name}"'


def copy(file, pattern, new, element):
    return text(f"{PACKAGE}/*/{file}", pattern, new, element)


FAULTS = table(
    "python",
    ("path of another file",
     text(MODULE, r'URDF_PATH = .*"(?P<old>\w+\.urdf)"', "arm.urdf", 'constant "URDF'),
     "C-PYTHON: "),
    ("path from another folder",
     text(MODULE, r"MJCF_PATH = _path.join\((?P<old>\w+)", "_path", 'constant "MJCF'),
     "C-PYTHON: "),
    ("path gone", text(MODULE, r"(?P<old>SCENE_PATH = .*\n)", "", 'constant "SCENE_PATH"'), "C-PYTHON: "),
    ("name not exported", text(MODULE, r'(?P<old>    "SRDF_PATH",\n)', "", 'constant "__all__"'),
     "C-PYTHON: "),
    ("module imports more", text(MODULE, r"(?P<old>)\n__version__", "\nimport os\n", "module"),
     "C-PYTHON: import os"),
    ("module not Python", text(MODULE, r"(?P<old>__all__ = )", "__all__ = = ", "file"), "C-PYTHON: "),
    ("project renamed", text(PROJECT, r'\nname = "(?P<old>\w+)"', "arm", "project"), "C-PYTHON: name"),
    ("files not in the wheel", text(PROJECT, r'packages = \["(?P<old>\w+)"', "arm", "tool"),
     "C-PYTHON: packages"),
    ("meshes left out of the wheel", text(PROJECT, r"ignore-vcs = (?P<old>true)", "false", "tool"),
     "C-PYTHON: ignore-vcs"),
    ("built by another tool", text(PROJECT, r'build-backend = "(?P<old>\S+)"', "flit", "build-system"),
     "C-PYTHON: "),
    ("readme that is not there", text(PROJECT, r'readme = "(?P<old>\S+)"', "HELLO.md", "project"),
     "C-PYTHON: readme"),
    ("URDF is an old copy", copy("*.urdf", r'<mass value="(?P<old>[^"]+)"', "9", "link"),
     "C-PYTHON: mass value"),
    ("MJCF is an old copy",
     copy("robot.xml", r'<body name="(?P<body>\w+)" pos="(?P<old>[^"]+)"', "0 0 9", 'body "{body}"'),
     "C-PYTHON: pos"),
    ("scene is an old copy", copy("scene.xml", r'"floor".*size="(?P<old>[^"]+)"', "9 9 1", "floor"),
     "C-PYTHON: size"),
    ("SDF is an old copy", copy("*.sdf", r"<mass>(?P<old>[^<]+)<", "9", "link"), "C-PYTHON: mass"),
    ("SRDF is an old copy", copy("*.srdf", r'reason="(?P<old>Adjacent)"', "Never", "disable_collisions"),
     "C-PYTHON: reason"),
    ("robot.json is an old copy", copy("robot.json", r'"mass": (?P<old>[\d.]+)', "9", "links"),
     "C-PYTHON: mass"),
    ("mesh gone", mesh_gone, "C-PYTHON: "),
    ("mesh is an old copy", mesh_changed, "C-PYTHON: "),
)  # fmt: skip
