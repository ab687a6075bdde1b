"""Paints the robot in a studio: with a soft shadow on a ground that fades into the background."""

import functools

import numpy as np

from linkwright.stages.show.preview.camera import Camera, framing
from linkwright.stages.show.preview.drawing.faces import Faces
from linkwright.stages.show.preview.drawing.pixels import blurred, enlarged, scattered
from linkwright.stages.show.preview.drawing.studio import LitRobot
from linkwright.stages.show.preview.drawing.vectors import dot
from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Indices, Numbers, Pixels, seen

FINER = 2
"""Samples for each pixel of the picture, each way."""

_BACKGROUND = np.array([0.905, 0.916, 0.928], dtype=np.float32)
"""Colour of the background in sRGB."""

_SHADOW = 0.62
"""Darkness of the ground where no light reaches it."""

_MIN_OPAQUE = 0.99
"""Faces with at least this opacity count as opaque."""

_SAME_DIRECTION = np.float32(0.96)
"""Cosine of an angle: faces at a smaller angle to each other share a colour within a pixel."""

_SHADOW_STEP = 3
"""Pixels of the picture for each pixel of the ground's shadow."""

_FADE_START, _FADE_END = 1.0, 2.1
"""Distances from the origin at which shadows on the ground begin to fade, and are gone."""


def picture(scene: LitRobot, width: int, height: int, framed: Numbers | None = None) -> Pixels:
    """Returns a picture (height, width, 3) that the robot, or the points `framed` (n, 3), fills."""
    points = scene.corners.reshape(-1, 3) if framed is None else framed
    return rendered(scene, framing(points, scene.backward, FINER * width, FINER * height))


def rendered(scene: LitRobot, camera: Camera) -> Pixels:
    """Returns the view of a camera, whose picture is `FINER` times as fine as the result. Only the nearest
    layer of transparent faces is drawn over the opaque faces."""
    placed = camera.projected(scene.corners)
    image = _ground(scene, camera)
    alpha = scene.surface.colours[scene.surface.geom, 3]
    opaque = np.flatnonzero(alpha >= _MIN_OPAQUE)
    if 0 < len(opaque) < len(placed):
        behind = seen(placed[opaque], camera.width, camera.height)
        _paint(image, scene, camera, placed, np.where(behind < 0, -1, opaque[behind]))
    _paint(image, scene, camera, placed, seen(placed, camera.width, camera.height))
    return np.asarray(np.rint(image * 255.0).astype(np.uint8))


def _paint(image: Single, scene: LitRobot, camera: Camera, placed: Single, which: Indices) -> None:
    """Draws over an image the triangles that are visible in each of its finer pixels, -1 without a
    triangle."""
    width = image.shape[1]
    parts = [which[row::FINER, column::FINER].ravel() for row in range(FINER) for column in range(FINER)]
    pixels = np.flatnonzero(functools.reduce(np.maximum, parts) >= 0)
    if not len(pixels):
        return
    finer = np.stack([part[pixels] for part in parts], axis=1)
    face = np.zeros(len(placed), dtype=np.int64)
    face[finer[finer >= 0]] = 1
    shown_faces = np.flatnonzero(face)
    face[shown_faces] = np.arange(len(shown_faces))
    faces = Faces(scene, placed, shown_faces)
    pixel, sub, weight = _samples(np.where(finer >= 0, face[finer], -1), faces)
    rows, columns = np.divmod(pixels[pixel], width)
    down, right = FINER * rows + sub // FINER, FINER * columns + sub % FINER
    which_face = face[finer[pixel, sub]]
    colours = faces.colours(camera, which_face, right + 0.5, down + 0.5, FINER)
    opacity = scene.surface.colours[scene.surface.geom[shown_faces], 3][which_face]
    share = (np.where(opacity >= _MIN_OPAQUE, 1.0, opacity) * weight).astype(np.float32)
    flat = image.reshape(-1, 3)
    covered = np.bincount(pixel, share, minlength=len(pixels)).astype(np.float32)
    flat[pixels] *= (1.0 - covered)[:, None]
    for channel in range(3):
        flat[pixels, channel] += np.bincount(pixel, share * colours[:, channel], minlength=len(pixels))


def _samples(face: Indices, faces: Faces) -> tuple[Indices, Indices, Single]:
    """Chooses the samples to draw: returns for each its pixel, its finer pixel, and its share of the pixel.

    `face` (n, 4): the face in each finer pixel, or -1. A single sample is enough if all finer pixels with a
    face show the same surface.
    """
    count = face.shape[1]
    covered = face >= 0
    first = covered.argmax(axis=1)
    first_face = face[np.arange(len(face)), first]
    several = np.zeros(len(face), dtype=np.bool_)
    for column in range(count):
        differing = np.flatnonzero(covered[:, column] & (face[:, column] != first_face))
        column_face, reference_face = face[differing, column], first_face[differing]
        is_parallel = dot(faces.flat[column_face], faces.flat[reference_face]) > _SAME_DIRECTION
        is_same = is_parallel & (faces.geom[column_face] == faces.geom[reference_face])
        several[differing[~is_same]] = True
    plain = np.flatnonzero(~several)
    pixel, sub = np.nonzero(covered & several[:, None])
    share = np.count_nonzero(covered, axis=1)[plain] / count
    return (
        np.concatenate([plain, pixel]),
        np.concatenate([first[plain], sub]),
        np.concatenate([share, np.full(len(pixel), 1 / count)]).astype(np.float32),
    )


def _ground(scene: LitRobot, camera: Camera) -> Single:
    """Returns the background (height, width, 3) with the shadow on the ground, in sRGB."""
    wide, high = camera.width // FINER, camera.height // FINER
    height, width = -(-high // _SHADOW_STEP), -(-wide // _SHADOW_STEP)
    rows, columns = np.divmod(np.arange(height * width), width)
    step = FINER * _SHADOW_STEP
    rays = camera.rays((columns + 0.5) * step, (rows + 0.5) * step)
    depth = np.divide(
        scene.floor - camera.position[2], rays[:, 2], out=np.full(len(rays), -1.0), where=rays[:, 2] < -1e-6
    )
    points = camera.position + depth[:, None] * rays
    away = np.sqrt((points[:, :2] ** 2).sum(axis=1))
    hit = np.flatnonzero((depth > 0) & (away < _FADE_END))
    single = np.ascontiguousarray(points[hit].astype(np.float32).T)
    shift = scattered(rows[hit], columns[hit])
    full = sum(lamp.power * lamp.direction[2] for lamp in scene.lamps)
    shades = np.zeros((2, len(rays)), dtype=np.float32)
    for lamp in scene.lamps:
        dark = ~lamp.reaches(single, shift, 0.5)
        shades[int(lamp.is_key), hit] += dark * np.float32(lamp.power * lamp.direction[2] / full)
    # Far shadows fade, so that none is cut off at the picture's edge.
    shades[:, hit] *= np.clip((_FADE_END - away[hit]) / (_FADE_END - _FADE_START), 0.0, 1.0)
    of_sky, of_key = shades.reshape(2, height, width)
    shade = enlarged(blurred(of_sky, 4) + blurred(of_key, 3), _SHADOW_STEP)[:high, :wide]
    return np.asarray(_BACKGROUND * (1.0 - np.float32(_SHADOW) * shade[:, :, None]), dtype=np.float32)
