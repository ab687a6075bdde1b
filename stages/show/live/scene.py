"""Makes the pack of a robot from the folder with its files."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.show.live.actuators import actuators
from linkwright.stages.show.live.beside_urdf import with_poses_and_constraints
from linkwright.stages.show.live.compiled import LiveModel, compile_live
from linkwright.stages.show.live.engine.copy import EngineCopy, NoCopy, engine_copy
from linkwright.stages.show.live.geoms import geoms
from linkwright.stages.show.live.links import links
from linkwright.stages.show.live.mechanism import bodies, frames, joints, keyframes, loops, relations
from linkwright.stages.show.live.meshes import stored_meshes
from linkwright.stages.show.live.pack import VERSION, Buffers, pack_bytes
from linkwright.stages.show.live.rounding import rounded, rounded_list

_DEFAULT_VIEW = 140.0, -20.0
"""Azimuth and elevation [degrees] of the view of a robot without a scene."""


MAX_BYTES = 8_000_000
"""Largest size [bytes] of a pack: with the engine and the tables a page has less than 20 MB."""

_ATTEMPTS = 4
"""Number of attempts to make the pack small enough; each has a quarter of the triangles of the last one."""


def pack_of(
    folder: Path, source: str, robot: Robot, colliders: Iterable[Mapping[str, Any]], faces: int
) -> bytes:
    """Makes the pack of the robot whose file `source` is in a folder. `colliders`: the rows of the report's
    table; `faces`: the largest number of triangles. Raises ValueError if MuJoCo refuses the file, or if the
    robot is too large."""
    live = compile_live(folder, source)
    head = _head(live, robot, links(robot, colliders))
    if live.document is None:
        head = with_poses_and_constraints(head, robot)
    engine = _engine(live, folder)
    if len(_pack_with(live, head, engine, 0)) > MAX_BYTES // 2:  # without triangles
        engine = NoCopy("the colliders are too large for a page")
    for attempt in range(_ATTEMPTS):
        pack = _pack_with(live, head, engine, faces // 4**attempt)
        if len(pack) <= MAX_BYTES:
            return pack
    raise ValueError(f"the robot is too large for a page: {len(pack) / 1e6:.0f} MB")


def _head(live: LiveModel, robot: Robot, link_entries: list[dict[str, Any]]) -> dict[str, Any]:
    """Returns the header without triangles and without the engine's copy."""
    link_indices = {entry["name"]: index for index, entry in enumerate(link_entries)}
    joint_entries = joints(live)
    return {
        "version": VERSION,
        "name": robot.name,
        "source": live.source,
        "bodies": bodies(live, link_indices),
        "joints": joint_entries,
        "relations": relations(live),
        "loops": loops(live),
        "keyframes": keyframes(live),
        "qpos0": rounded_list(live.model.qpos0),
        "activations": int(live.model.na),
        "actuators": actuators(live, joint_entries),
        "frames": frames(live),
        "gravity": rounded_list(live.model.opt.gravity),
        "timestep": rounded(live.model.opt.timestep),
        "camera": _camera(live),
        "links": link_entries,
    }


def _pack_with(live: LiveModel, head: dict[str, Any], engine: EngineCopy | NoCopy, faces: int) -> bytes:
    buffers = Buffers()
    mesh_entries = stored_meshes(live.model, geoms(live), faces, buffers) if faces else {}
    if isinstance(engine, NoCopy):
        return pack_bytes({**head, **mesh_entries, "engine": None, "no_engine": str(engine)}, buffers)
    places = {name: {"at": buffers.add(data), "bytes": len(data)} for name, data in engine.files.items()}
    copy = {"xml": engine.text, "files": places, "lacks": engine.lacks}
    return pack_bytes({**head, **mesh_entries, "engine": copy, "no_engine": None}, buffers)


def _engine(live: LiveModel, folder: Path) -> EngineCopy | NoCopy:
    """Returns the engine's copy of the model, or the reason why there is none."""
    try:
        return engine_copy(live, folder)
    except NoCopy as reason:
        return reason


def _camera(live: LiveModel) -> dict[str, Any]:
    view = live.model.vis.global_
    azimuth, elevation = _DEFAULT_VIEW if live.document is None else (view.azimuth, view.elevation)
    return {
        "center": rounded_list(live.model.stat.center),
        "extent": rounded(live.model.stat.extent),
        "azimuth": rounded(azimuth),
        "elevation": rounded(elevation),
    }
