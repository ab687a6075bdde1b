"""The text files of a Python package: `pyproject.toml`, built by hatchling, which leaves nothing beside the
sources, `README.md` and `__init__.py`.

The constants have the names of those of robot_descriptions, whose loaders take a module that has them.
"""

import json
from collections.abc import Collection
from pathlib import Path

from linkwright.stages.export.python.section import PythonFormatSection, module_of
from linkwright.stages.formats.templates import Templates

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


def _text(value: str) -> str:
    # A text of JSON is one of TOML and of Python, where it has no character by two escapes.
    return json.dumps(value, ensure_ascii=False)


_TEMPLATES = Templates(Path(__file__).with_name("templates"), {"text": _text})


def text_files(
    package: str, robot: str, folder: str, keys: PythonFormatSection, paths: Collection[str]
) -> dict[str, bytes]:
    """The files by path. `folder`: that of the robot's files, in the module's; `paths`: of these."""
    module = module_of(package)
    every = {name: path.format(robot) for name, path in OF_FILES}
    constants = {name: path for name, path in every.items() if path in paths}
    values = {
        "package": package,
        "module": module,
        "robot": robot,
        "folder": folder,
        "keys": keys,
        "constants": constants,
        "first": next(iter(constants), "PACKAGE_PATH"),
        "names": sorted(["PACKAGE_PATH", "REPOSITORY_PATH", *constants, "__version__"]),
    }
    templates = {
        "pyproject.toml": "pyproject.toml",
        "README.md": "README.md",
        f"{module}/__init__.py": "module.py",
    }
    return {path: _TEMPLATES.filled(name, **values).encode() for path, name in templates.items()}
