"""Writes the text files of a Python package: `pyproject.toml`, `README.md` and `__init__.py`.

hatchling builds the package, because it leaves no files next to the sources. The constants have the names
that robot_descriptions uses, so that its loaders take the module.
"""

import json
from collections.abc import Collection
from pathlib import Path

from linkwright.stages.export.python.section import PythonFormatSection, import_name
from linkwright.stages.formats.templates import Templates

PATH_CONSTANTS = (
    ("URDF_PATH", "{}.urdf"),
    ("SRDF_PATH", "{}.srdf"),
    ("MJCF_PATH", "{}.xml"),
    ("SCENE_PATH", "scene.xml"),
    ("SDF_PATH", "{}.sdf"),
    ("USD_PATH", "{}.usda"),
    ("ROBOT_JSON_PATH", "robot.json"),
)
"""(constant, path), where {} stands for the name of the robot."""


def _text(value: str) -> str:
    # JSON text is also valid TOML and Python, unless two escapes form one character: hence no ASCII escapes.
    return json.dumps(value, ensure_ascii=False)


_TEMPLATES = Templates(Path(__file__).with_name("templates"), {"text": _text})


def text_files(
    package: str, robot: str, folder: str, keys: PythonFormatSection, paths: Collection[str]
) -> dict[str, bytes]:
    """Returns path → content. `folder`: the folder of the robot's files in the module's folder; `paths`:
    their paths in it."""
    module = import_name(package)
    all_constants = {name: path.format(robot) for name, path in PATH_CONSTANTS}
    constants = {name: path for name, path in all_constants.items() if path in paths}
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
