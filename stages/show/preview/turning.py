"""Draws the robot, also as an animation in which it turns, in a guest process; needs pillow (extra
`turn`)."""

import math

from linkwright.stages.show.preview import TURN
from linkwright.stages.show.preview.drawing.painting import draw_picture
from linkwright.stages.show.preview.drawing.studio import LitRobot, swept_points, turned_by
from linkwright.stages.show.preview.guest import pictures, reply, scene
from linkwright.stages.show.preview.webp import encode

SIZE = 480, 360
"""Width and height of the animation [pixels]."""
FRAMES = 36
"""Number of frames of a turn."""

FRAME_TIME = 100
"""Time that each frame is shown [ms]."""


def answer(request: bytes) -> bytes:
    """Answers as `guest.answer` does, with the turning robot too."""
    robot = scene(request)
    return reply({**pictures(robot), TURN: _turn(robot)})


def _turn(robot: LitRobot) -> bytes:
    """Returns a WebP with a full turn of the robot, in a loop."""
    framed_points = swept_points(robot)
    angles = [2 * math.pi * frame / FRAMES for frame in range(FRAMES)]
    return encode(
        [draw_picture(turned_by(robot, angle), *SIZE, points=framed_points) for angle in angles], FRAME_TIME
    )
