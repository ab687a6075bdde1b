"""Guest process that draws the robot: many triangles take memory, and time."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.formats import png
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.show.preview import PICTURE, SMALL, TURN
from linkwright.stages.show.preview.drawing.painting import picture
from linkwright.stages.show.preview.drawing.pixels import reduced
from linkwright.stages.show.preview.drawing.studio import LitRobot, studio, swept, turned_by
from linkwright.stages.show.preview.look import unpacked
from linkwright.stages.show.preview.surface import surface_of

if TYPE_CHECKING:
    from linkwright.stages.show.raster import Pixels

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
    """To a packed look (`preview.look`): a line of JSON with the names and lengths of the pictures, and the
    pictures.

    SourceError where nothing of the robot has a place.
    """
    look, kind = unpacked(request)
    try:
        surface = surface_of(look)
    except ValueError as error:
        raise SourceError(str(error)) from None
    scene = studio(surface, np.array(look.backward))
    large = picture(scene, *SIZE)
    found = {PICTURE: png.encode(large), SMALL: _small(large)}
    if kind == "turn":
        found[TURN] = _turn(scene)
    head = {"files": [[name, len(data)] for name, data in found.items()]}
    return b"".join([json.dumps(head).encode(), b"\n", *found.values()])


def _small(large: Pixels) -> bytes:
    """The largest of the small pictures that is small enough for a page."""
    for times in SMALLER:
        data = png.encode(reduced(large, times))
        if len(data) <= SMALL_BYTES:
            break
    return data


def _turn(scene: LitRobot) -> bytes:
    """The robot as it turns once, and again."""
    # Late: only a turn needs it.
    from linkwright.stages.show.preview.webp import encode

    framed = swept(scene)
    frames: list[Pixels] = []
    for frame in range(FRAMES):
        frames.append(picture(turned_by(scene, 2 * math.pi * frame / FRAMES), *TURN_SIZE, framed=framed))
    return encode(frames, FRAME)
