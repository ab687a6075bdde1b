"""Draws a picture of the robot, in a guest process, since many triangles take memory and time."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.formats import png
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.show.preview import PICTURE, SMALL
from linkwright.stages.show.preview.drawing.painting import draw_picture
from linkwright.stages.show.preview.drawing.pixels import reduce_picture
from linkwright.stages.show.preview.drawing.studio import LitRobot, studio
from linkwright.stages.show.preview.look import unpacked
from linkwright.stages.show.preview.surface import surface_of

if TYPE_CHECKING:
    from linkwright.stages.show.raster import Pixels

SIZE = 960, 720
"""Width and height of the picture [pixels]."""

REDUCTIONS = (2, 3, 4, 6)
"""Factors by which the small picture may be smaller; the first that gives at most `MAX_SMALL_BYTES` is
used."""

MAX_SMALL_BYTES = 66_000
"""Largest size of the small picture [bytes], if a factor allows it."""


def answer(request: bytes) -> bytes:
    """Answers a packed look (`preview.look`) with its pictures, in the form of `reply`. Raises SourceError if
    no part of the robot has finite coordinates."""
    return reply(pictures(scene(request)))


def scene(request: bytes) -> LitRobot:
    """Returns the robot of a packed look among lamps. Raises SourceError if no part of it has finite
    coordinates."""
    look = unpacked(request)
    try:
        surface = surface_of(look)
    except ValueError as error:
        raise SourceError(str(error)) from None
    return studio(surface, np.array(look.backward))


def pictures(robot: LitRobot) -> dict[str, bytes]:
    """Returns the picture of a robot and a small picture, by name."""
    large = draw_picture(robot, *SIZE)
    return {PICTURE: png.encode(large), SMALL: _small_picture(large)}


def reply(files: Mapping[str, bytes]) -> bytes:
    """Packs files as a line of JSON with their names and lengths, and their contents."""
    head = {"files": [[name, len(data)] for name, data in files.items()]}
    return b"".join([json.dumps(head).encode(), b"\n", *files.values()])


def _small_picture(large: Pixels) -> bytes:
    """Returns the picture as a PNG, reduced until it has few enough bytes for a page."""
    for factor in REDUCTIONS:
        data = png.encode(reduce_picture(large, factor))
        if len(data) <= MAX_SMALL_BYTES:
            break
    return data
