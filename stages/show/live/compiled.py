"""The compiled model of a build, of which the page shows everything by index."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco

from linkwright.stages.formats.xml import Element, to_bytes
from linkwright.stages.mujoco.compile import compiled_file, compiled_heard, compiled_text, spec_of_text
from linkwright.stages.mujoco.names import name_of
from linkwright.stages.mujoco.state import at_key, keyframe_of
from linkwright.stages.mujoco.warnings import listening
from linkwright.stages.show.live import includes
from linkwright.stages.show.preview.model_text import urdf_text


@dataclass(frozen=True, slots=True, eq=False)
class LiveModel:
    """A robot as MuJoCo compiled it. `source`: its file; `document`: the scene with its includes resolved and
    every body and geom named, None of a URDF. `closed`: the model's state at a pose in which its loops are
    closed: the keyframe `home`, else the first one, else where the model starts."""

    source: str
    model: Any
    closed: Any
    document: Element | None
    actuators: tuple[str, ...] = ()

    def name(self, kind: Any, index: int) -> str:
        """The name of one of the model's objects; "" where its file gives it none."""
        found = name_of(self.model, kind, index)
        return "" if found.startswith(includes.OWN) else found


def compiled(folder: Path, source: str) -> LiveModel:
    """Compiles the file `source` of a folder with a robot's files. ValueError where MuJoCo refuses it."""
    document = None
    with listening():
        if source.endswith(".urdf"):
            model = _of_urdf(folder, source)
        else:
            document = includes.with_names(includes.flat(folder, source))
            model, _ = compiled_heard(lambda: spec_of_text(to_bytes(document), folder))
        closed = _closed(model)
    tags = () if document is None else includes.actuator_tags(document)
    return LiveModel(source, model, closed, document, tags)


def _of_urdf(folder: Path, source: str) -> Any:
    """The model of a URDF with all that is seen; that of a ROS package lies beside its meshes'
    folder."""
    if "/" not in source:
        return compiled_file(folder / source)
    paths = (path for path in sorted(folder.rglob("*")) if path.is_file())
    files = {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
    text, meshes = urdf_text(source, files)
    return compiled_text(text, meshes)


def _closed(model: Any) -> Any:
    data = at_key(model, max(keyframe_of(model, "home"), 0) if model.nkey else -1)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return data
