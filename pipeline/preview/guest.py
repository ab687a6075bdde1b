"""Guest process that draws the robot: MuJoCo compiles what was exported, and many triangles take memory."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import mujoco

from pipeline.preview import PICTURE, SMALL, TURN
from pipeline.preview.compiled import seen_in
from pipeline.preview.model_text import mjcf_text, urdf_text
from pipeline.preview.pixels import reduced
from pipeline.preview.studio import LitRobot, picture, studio, swept, turned_by
from stages.formats import png
from stages.robot.errors import SourceError
from stages.robot.mujoco_warnings import listening

if TYPE_CHECKING:
    from stages.mesh.view.raster import Pixels

SIZE = 960, 720
SMALLER = (2, 3, 4, 6)
"""By how much the small picture is smaller: by the first of these that gives few enough bytes."""

SMALL_BYTES = 66_000
TURN_SIZE = 480, 360
FRAMES = 36
"""Of a turn."""

FRAME = 100
"""How long each is shown [ms]."""


def answer(request: bytes) -> bytes:
    """To a line of JSON, {"model": path of a scene or URDF, "kind", "files": [[path, length], ...]}, and the
    files: a line of JSON with the names and lengths of the pictures, and the pictures.

    SourceError where MuJoCo cannot compile the model.
    """
    at = request.index(b"\n") + 1
    asked = json.loads(request[:at])
    files = dict[str, bytes]()
    for path, length in asked["files"]:
        files[path] = request[at : at + length]
        at += length
    model, values = _compiled(asked["model"], files)
    scene = studio(seen_in(model, values))
    large = picture(scene, *SIZE)
    found = {PICTURE: png.encode(large), SMALL: _small(large)}
    if asked["kind"] == "turn":
        found[TURN] = _turn(scene)
    head = {"files": [[name, len(data)] for name, data in found.items()]}
    return b"".join([json.dumps(head).encode(), b"\n", *found.values()])


def _compiled(path: str, files: Mapping[str, bytes]) -> tuple[Any, dict[str, float]]:
    """The model, and the joints' values at home for one that has no keyframe."""
    values = dict[str, float]()
    with listening():
        try:
            if path.endswith(".urdf"):
                text, meshes = urdf_text(path, files)
                values = _home(files["robot.json"])
            else:
                text, meshes = mjcf_text(path, files)
            return mujoco.MjSpec.from_string(text, assets=dict(meshes)).compile(), values
        except (ValueError, KeyError, RuntimeError, MemoryError, mujoco.FatalError) as error:
            words = " ".join(str(error).split())[:300]
            raise SourceError(f"MuJoCo cannot compile {path}: {words}", path) from None


def _home(robot: bytes) -> dict[str, float]:
    for keyframe in json.loads(robot).get("keyframes", []):
        if keyframe["name"] == "home":
            return {name: float(value) for name, value in keyframe["values"].items() if _is_number(value)}
    return {}


def _is_number(value: object) -> bool:
    return isinstance(value, int | float)


def _small(large: Pixels) -> bytes:
    """The largest of the small pictures that is small enough for a page."""
    for times in SMALLER:
        data = png.encode(reduced(large / 255.0, times))
        if len(data) <= SMALL_BYTES:
            break
    return data


def _turn(scene: LitRobot) -> bytes:
    """The robot as it turns once, and again."""
    from pipeline.preview.webp import encode

    framed = swept(scene)
    frames: list[Pixels] = []
    for frame in range(FRAMES):
        frames.append(picture(turned_by(scene, 2 * math.pi * frame / FRAMES), *TURN_SIZE, framed=framed))
    return encode(frames, FRAME)
