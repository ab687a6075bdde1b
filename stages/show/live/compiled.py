"""Compiles the model of a build, to whose indices the page refers."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco

from linkwright.stages.formats.meshes.gltf_conventions import SUFFIX
from linkwright.stages.formats.xml import Element, to_bytes
from linkwright.stages.mujoco.compile import (
    compiled_file,
    compiled_text,
    compiled_with_warnings,
    spec_of_text,
)
from linkwright.stages.mujoco.names import name_of
from linkwright.stages.mujoco.state import at_keyframe_index, keyframe_index
from linkwright.stages.mujoco.warnings import collected_warnings
from linkwright.stages.show.live import includes
from linkwright.stages.show.preview.model_text import urdf_text


@dataclass(frozen=True, slots=True, eq=False)
class LiveModel:
    """A robot as MuJoCo compiled it."""

    source: str
    """The path of the robot's file."""

    model: Any
    closed_data: Any
    """MuJoCo's data at a pose with closed loops: the keyframe `home`, else the first keyframe, else the
    start."""

    document: Element | None
    """The scene without includes, in which every body and geom has a name; None for a URDF."""

    actuators: tuple[str, ...] = ()
    """The tag of each actuator in the scene."""

    def name(self, kind: Any, index: int) -> str:
        """Returns the name of an object of the model in the robot's file; "" if it has none there."""
        name = name_of(self.model, kind, index)
        return "" if name.startswith(includes.NAME_PREFIX) else name


def compile_live(folder: Path, source: str) -> LiveModel:
    """Compiles the file `source` of a folder with a robot's files. Raises ValueError if MuJoCo refuses it."""
    document = None
    with collected_warnings():
        if source.endswith(".urdf"):
            model = _model_of_urdf(folder, source)
        else:
            document = includes.with_names(includes.without_includes(folder, source))
            model, _ = compiled_with_warnings(lambda: spec_of_text(to_bytes(document), folder))
        closed_data = _data_at_home(model)
    tags = () if document is None else includes.actuator_tags(document)
    return LiveModel(source, model, closed_data, document, tags)


def _model_of_urdf(folder: Path, source: str) -> Any:
    """Compiles a URDF with all visible shapes. The URDF of a ROS package is in a folder beside that of its
    meshes."""
    if "/" not in source and SUFFIX.encode() not in (folder / source).read_bytes():
        return compiled_file(folder / source)
    paths = (path for path in sorted(folder.rglob("*")) if path.is_file())
    files = {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
    model = urdf_text(source, files)
    return compiled_text(model.text, model.files)


def _data_at_home(model: Any) -> Any:
    data = at_keyframe_index(model, max(keyframe_index(model, "home"), 0) if model.nkey else -1)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return data
