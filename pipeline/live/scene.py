"""The whole pack of a robot, from the folder with its files."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pipeline.live.actuators import actuators
from pipeline.live.compiled import LiveModel, compiled
from pipeline.live.engine import NoCopy, engine_copy
from pipeline.live.geoms import geoms
from pipeline.live.links import links
from pipeline.live.mechanism import bodies, frames, joints, keyframes, loops, relations
from pipeline.live.meshes import stored_meshes
from pipeline.live.pack import VERSION, Buffers, packed
from pipeline.live.rounding import rounded, vector
from stages.robot.model import Robot

_VIEW = 140.0, -20.0
"""Azimuth and elevation [degrees] from which a robot without a scene is seen."""


def pack_of(
    folder: Path, source: str, robot: Robot, colliders: Iterable[Mapping[str, Any]], faces: int
) -> bytes:
    """The pack of the robot whose file `source` is in a folder. `colliders`: the rows of the report's table;
    `faces`: the most triangles. ValueError where MuJoCo does not compile it."""
    live = compiled(folder, source)
    buffers = Buffers()
    known = links(robot, colliders)
    numbers = {one["name"]: index for index, one in enumerate(known)}
    moving = joints(live)
    header = {
        "version": VERSION,
        "name": robot.name,
        "source": source,
        "bodies": bodies(live, numbers),
        "joints": moving,
        "relations": relations(live),
        "loops": loops(live),
        "keyframes": keyframes(live),
        "qpos0": vector(live.model.qpos0),
        "actuators": actuators(live, moving),
        **stored_meshes(live.model, geoms(live), faces, buffers),
        "frames": frames(live),
        "gravity": vector(live.model.opt.gravity),
        "timestep": rounded(live.model.opt.timestep),
        "camera": _camera(live),
        "links": known,
        **_engine(live, folder, buffers),
    }
    return packed(header, buffers)


def _engine(live: LiveModel, folder: Path, buffers: Buffers) -> dict[str, Any]:
    """The engine's copy of the model; where it has none, `no_engine` says why."""
    try:
        text, files, lacks = engine_copy(live, folder)
    except NoCopy as reason:
        return {"engine": None, "no_engine": str(reason)}
    places = {name: {"at": buffers.add(data), "bytes": len(data)} for name, data in files.items()}
    return {"engine": {"xml": text, "files": places, "lacks": lacks}, "no_engine": None}


def _camera(live: LiveModel) -> dict[str, Any]:
    view = live.model.vis.global_
    azimuth, elevation = _VIEW if live.document is None else (view.azimuth, view.elevation)
    return {
        "center": vector(live.model.stat.center),
        "extent": rounded(live.model.stat.extent),
        "azimuth": rounded(azimuth),
        "elevation": rounded(elevation),
    }
