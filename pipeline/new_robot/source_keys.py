"""Reads an address or a path as the keys of a source, and chooses the robot's name."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from linkwright.pipeline.config.choices import default_robot_name
from linkwright.pipeline.config.presets import OURS
from linkwright.pipeline.errors import ConfigError
from linkwright.stages.robot.system import regular_files
from linkwright.stages.robot.text.names import legal_name

SHIPPED = tuple(sorted(file.stem for file in (OURS / "robot").glob("*.yaml")))
"""The robots of the package, whose names no other robot can have."""

_KINDS = {".zip": "bundle", ".urdf": "urdf", ".xacro": "urdf"}
_ADDRESS = re.compile(r"[a-z][a-z0-9+.-]*://", re.IGNORECASE)
_HEAD_BYTES = 1 << 16
"""Size of the beginning of an XML file in which its first tag must be [bytes]."""


def source_keys(text: str) -> dict[str, Any]:
    """Returns the keys of the source that an address or a path names. Raises ConfigError for a file that is
    neither a URDF, an MJCF nor a bundle."""
    if _ADDRESS.match(text) or text.startswith("cad.onshape.com"):
        return {"kind": "onshape", "url": text}
    path = Path(text)
    regular_files.require(text, "new", "it takes the address of an assembly, or a file", "robots/arm.urdf")
    kind = _KINDS.get(path.suffix.lower()) or _kind_of_xml(path)
    if kind is None:
        msg = "it is neither a URDF, an MJCF (MuJoCo XML) nor a bundle (zip)"
        raise ConfigError(msg, text, "linkwright new --help shows what it takes")
    return {"kind": kind, "path": text}


def _kind_of_xml(path: Path) -> str | None:
    """Returns the kind of a file by the first tag in it; None for other files."""
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD_BYTES).decode("utf-8", errors="replace")
    except OSError:
        return None
    without_comments = re.sub(r"<!--.*?-->", "", head, flags=re.DOTALL)
    tag = re.search(r"<([A-Za-z][\w.:-]*)", without_comments)
    return {"mujoco": "mjcf", "robot": "urdf"}.get(tag[1]) if tag else None


def robot_name(name: str, source: Mapping[str, Any], title: str = "") -> str:
    """Returns the name of the robot: the user's, else that of the assembly's tab, else by the source.

    Raises ConfigError for a name that no robot's file can have.
    """
    new_name = name or legal_name(title) or default_robot_name(source)
    where = "new"
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_-]*", new_name):
        msg = f"a robot's name has letters, digits, _ and - only, got {name!r}"
        hint = f"for example {legal_name(name) or 'my_arm'}"
        raise ConfigError(msg, where, hint)
    if new_name.lower() in (*SHIPPED, "scene"):
        msg = f"{new_name!r} is the name of a robot or file of Linkwright"
        raise ConfigError(msg, where, f"give the robot another name, such as my_{new_name.lower()}")
    return new_name
