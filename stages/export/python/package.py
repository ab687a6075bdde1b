"""The text files of a Python package: `pyproject.toml`, `README.md`, `__init__.py`.

The constants have the names of those of robot_descriptions, whose loaders take a module that has them.
"""

import json
from collections.abc import Collection

from linkwright.stages.export.python.section import PythonFormatSection, module_of

OF_FILES = (
    ("URDF_PATH", "{}.urdf"),
    ("SRDF_PATH", "{}.srdf"),
    ("MJCF_PATH", "{}.xml"),
    ("SCENE_PATH", "scene.xml"),
    ("SDF_PATH", "{}.sdf"),
    ("USD_PATH", "{}.usda"),
    ("ROBOT_JSON_PATH", "robot.json"),
)
"""Constant → the file of a robot of a name."""


def constants(robot: str, paths: Collection[str]) -> list[tuple[str, str]]:
    """(constant, path) of the files that there are."""
    every = [(name, path.format(robot)) for name, path in OF_FILES]
    return [(name, path) for name, path in every if path in paths]


def pyproject(package: str, robot: str, keys: PythonFormatSection) -> bytes:
    """Built by hatchling, which leaves nothing beside the sources."""
    about = [f"name = {_text(package)}", f"version = {_text(keys.version)}"]
    about += [
        f"description = {_text(f'The robot {robot}: its files and their paths.')}",
        'readme = "README.md"',
    ]
    about += ['requires-python = ">=3.8"']
    if keys.license is not None:
        about.append(f"license = {{ text = {_text(keys.license)} }}")
    if keys.author is not None:
        about.append(f"authors = [{{ name = {_text(keys.author)} }}]")
    lines = [
        "[build-system]",
        'requires = ["hatchling"]',
        'build-backend = "hatchling.build"',
        "",
        "[project]",
        *about,
        "",
        "[tool.hatch.build]",
        "# Meshes belong to it also where a .gitignore above names them.",
        "ignore-vcs = true",
        "",
        "[tool.hatch.build.targets.wheel]",
        f"packages = [{_text(module_of(package))}]",
    ]
    return ("\n".join(lines) + "\n").encode()


def module(package: str, robot: str, folder: str, version: str, paths: Collection[str]) -> bytes:
    """`__init__.py`. `folder`: that of the robot's files, in the module's; `paths`: of these."""
    found = constants(robot, paths)
    named = [f"{name} = _path.join(PACKAGE_PATH, {_text(path)})" for name, path in found]
    first = found[0][0] if found else "PACKAGE_PATH"
    every = ["PACKAGE_PATH", "REPOSITORY_PATH", *(name for name, _ in found), "__version__"]
    lines = [
        f'"""The files of the robot {robot}.',
        "",
        f"    import {module_of(package)}",
        "",
        f"    {module_of(package)}.{first}",
        '"""',
        "",
        "from os import path as _path",
        "",
        f"__version__ = {_text(version)}",
        "",
        "REPOSITORY_PATH = _path.dirname(_path.abspath(__file__))",
        f"PACKAGE_PATH = _path.join(REPOSITORY_PATH, {_text(folder)})",
        *named,
        "",
        "__all__ = [",
        *(f"    {_text(name)}," for name in sorted(every)),
        "]",
    ]
    return ("\n".join(lines) + "\n").encode()


def readme(package: str, robot: str, paths: Collection[str]) -> bytes:
    """What the page of the package says."""
    rows = [f"| `{name}` | `{path}` |" for name, path in constants(robot, paths)]
    lines = [
        f"# {package}",
        "",
        f"The files of the robot {robot}, and their paths:",
        "",
        "```python",
        f"import {module_of(package)} as robot",
        "",
        "print(robot.PACKAGE_PATH)",
        "```",
        "",
        "| constant | file |",
        "| --- | --- |",
        *rows,
        "| `PACKAGE_PATH` | the folder of these files and their meshes |",
        "| `REPOSITORY_PATH` | the folder above that |",
    ]
    return ("\n".join(lines) + "\n").encode()


def _text(value: str) -> str:
    # A text of JSON is one of TOML and of Python, where it has no character by two escapes.
    return json.dumps(value, ensure_ascii=False)
