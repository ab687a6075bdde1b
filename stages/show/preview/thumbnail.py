"""Draws a thumbnail of the robot, a small square picture, in a guest process."""

from linkwright.stages.formats import png
from linkwright.stages.show.preview import THUMBNAIL
from linkwright.stages.show.preview.drawing.painting import draw_picture
from linkwright.stages.show.preview.guest import reply, scene

SIDE = 256
"""The width and height of a thumbnail [pixels]."""


def answer(request: bytes) -> bytes:
    """Answers a packed look (`preview.look`) with its thumbnail, in the form of `guest.reply`. Raises
    SourceError if no part of the robot has finite coordinates."""
    return reply({THUMBNAIL: png.encode(draw_picture(scene(request), SIDE, SIDE))})
