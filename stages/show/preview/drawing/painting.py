"""Paints the robot in a studio: with a soft shadow on a ground that fades into the background."""

import functools

import numpy as np

from linkwright.stages.show.preview.camera import Camera, framing
from linkwright.stages.show.preview.drawing.faces import Faces
from linkwright.stages.show.preview.drawing.pixels import blur, enlarge, pixel_shifts
from linkwright.stages.show.preview.drawing.studio import LitRobot
from linkwright.stages.show.preview.drawing.vectors import dot
from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Indices, Numbers, Pixels, nearest_triangles

SAMPLES_PER_SIDE = 2
"""Number of samples along each side of a pixel: the camera's picture has as many times the pixels of the
final picture, each way."""

_BACKGROUND = np.array([0.905, 0.916, 0.928], dtype=np.float32)
"""Colour of the background in sRGB."""

_SHADOW_DARKNESS = 0.62
"""Share of the background's colour that the ground loses where no light reaches it."""

_MIN_OPAQUE_ALPHA = 0.99
"""Faces with at least this opacity count as opaque."""

_MIN_COSINE = np.float32(0.96)
"""Cosine of an angle: faces at a smaller angle to each other share a colour within a pixel."""

_SHADOW_PIXEL_SIZE = 3
"""Width of a pixel of the ground's shadow, in pixels of the final picture."""

_SHADOW_SLACK = 0.5
"""Depth behind a lamp's nearest point, in pixels of the lamp, up to which the ground is still lit."""

_SKY_BLUR, _KEY_BLUR = 4, 3
"""Half widths of the blur of the shadows of sky and key light, in pixels of the ground's shadow."""

_FADE_START, _FADE_END = 1.0, 2.1
"""Distances from the middle, in radii of the robot, at which shadows on the ground begin to fade, and are
gone."""


def draw_picture(scene: LitRobot, width: int, height: int, points: Numbers | None = None) -> Pixels:
    """Draws a picture (height, width, 3) that is filled by the robot, or by the `points` (n, 3) if there are
    any. `width`, `height` [pixels]."""
    shown_points = scene.corners.reshape(-1, 3) if points is None else points
    size = SAMPLES_PER_SIDE * width, SAMPLES_PER_SIDE * height
    return render(scene, framing(shown_points, scene.backward, *size))


def render(scene: LitRobot, camera: Camera) -> Pixels:
    """Draws what a camera sees, reduced by `SAMPLES_PER_SIDE` each way: (height, width, 3).

    Only the nearest layer of transparent faces is drawn over the opaque faces.
    """
    corners = camera.projected(scene.corners)
    image = _ground(scene, camera)
    alpha = scene.surface.colours[scene.surface.geom, 3]
    opaque = np.flatnonzero(alpha >= _MIN_OPAQUE_ALPHA)
    # Opaque faces are drawn first, so that they are visible through transparent ones.
    if 0 < len(opaque) < len(corners):
        nearest_opaque = nearest_triangles(corners[opaque], camera.width, camera.height)
        _paint(image, scene, camera, corners, np.where(nearest_opaque < 0, -1, opaque[nearest_opaque]))
    _paint(image, scene, camera, corners, nearest_triangles(corners, camera.width, camera.height))
    return np.asarray(np.rint(image * 255.0).astype(np.uint8))


def _paint(image: Single, scene: LitRobot, camera: Camera, corners: Single, visible: Indices) -> None:
    """Draws triangles over an image (height, width, 3) in sRGB.

    `corners` (m, 3, 3): the scene's triangles in the camera's picture; `visible`: the triangle that each
    pixel of the camera's picture, a sample, shows, or -1.
    """
    side = SAMPLES_PER_SIDE
    width = image.shape[1]
    # An array for each place in a pixel, row by row, with the sample there of each pixel.
    by_place = [visible[row::side, column::side].ravel() for row in range(side) for column in range(side)]
    pixels = np.flatnonzero(functools.reduce(np.maximum, by_place) >= 0)
    if not len(pixels):
        return
    triangles = np.stack([samples[pixels] for samples in by_place], axis=1)
    # Only visible triangles get colours: a face is a triangle's index among them.
    face_of_triangle = np.zeros(len(corners), dtype=np.int64)
    face_of_triangle[triangles[triangles >= 0]] = 1
    visible_triangles = np.flatnonzero(face_of_triangle)
    face_of_triangle[visible_triangles] = np.arange(len(visible_triangles))
    face_of_sample = np.where(triangles >= 0, face_of_triangle[triangles], -1)
    faces = Faces(scene, corners, visible_triangles)
    pixel, sample, share = _drawn_samples(face_of_sample, faces)
    face = face_of_sample[pixel, sample]
    rows, columns = np.divmod(pixels[pixel], width)
    down, right = side * rows + sample // side, side * columns + sample % side
    # Half a pixel further is the middle of the sample.
    colours = faces.colours(camera, face, right + 0.5, down + 0.5, side)
    alpha = scene.surface.colours[scene.surface.geom[visible_triangles], 3][face]
    weight = (np.where(alpha >= _MIN_OPAQUE_ALPHA, 1.0, alpha) * share).astype(np.float32)
    flat_image = image.reshape(-1, 3)
    covered = np.bincount(pixel, weight, minlength=len(pixels)).astype(np.float32)
    flat_image[pixels] *= (1.0 - covered)[:, None]
    for channel in range(3):
        flat_image[pixels, channel] += np.bincount(pixel, weight * colours[:, channel], minlength=len(pixels))


def _drawn_samples(face: Indices, faces: Faces) -> tuple[Indices, Indices, Single]:
    """Chooses the samples whose colours are computed. Returns for each the index of its pixel, its index in
    the pixel, and its share of the pixel.

    `face` (pixels, samples): the face that each sample shows, or -1. If all samples of a pixel with a face
    show the same surface, the first of them is enough.
    """
    sample_count = face.shape[1]
    is_covered = face >= 0
    first_sample = is_covered.argmax(axis=1)
    first_face = face[np.arange(len(face)), first_sample]
    shows_several = np.zeros(len(face), dtype=np.bool_)
    for sample in range(sample_count):
        differing = np.flatnonzero(is_covered[:, sample] & (face[:, sample] != first_face))
        other_face, reference_face = face[differing, sample], first_face[differing]
        is_parallel = dot(faces.flat[other_face], faces.flat[reference_face]) > _MIN_COSINE
        is_same = is_parallel & (faces.geom[other_face] == faces.geom[reference_face])
        shows_several[differing[~is_same]] = True
    plain = np.flatnonzero(~shows_several)
    pixel, sample_index = np.nonzero(is_covered & shows_several[:, None])
    plain_share = np.count_nonzero(is_covered, axis=1)[plain] / sample_count
    return (
        np.concatenate([plain, pixel]),
        np.concatenate([first_sample[plain], sample_index]),
        np.concatenate([plain_share, np.full(len(pixel), 1 / sample_count)]).astype(np.float32),
    )


def _ground(scene: LitRobot, camera: Camera) -> Single:
    """Draws the background (height, width, 3) with the shadow on the ground, in sRGB.

    The shadow is soft, so it is computed for larger pixels, and enlarged.
    """
    image_width, image_height = camera.width // SAMPLES_PER_SIDE, camera.height // SAMPLES_PER_SIDE
    # Rounded up.
    width, height = -(-image_width // _SHADOW_PIXEL_SIZE), -(-image_height // _SHADOW_PIXEL_SIZE)
    rows, columns = np.divmod(np.arange(height * width), width)
    step = SAMPLES_PER_SIDE * _SHADOW_PIXEL_SIZE
    rays = camera.rays((columns + 0.5) * step, (rows + 0.5) * step)
    # Rays that do not go down never meet the ground: -1.
    goes_down = rays[:, 2] < -1e-6
    depth = np.divide(
        scene.floor - camera.position[2], rays[:, 2], out=np.full(len(rays), -1.0), where=goes_down
    )
    points = camera.position + depth[:, None] * rays
    distance = np.sqrt((points[:, :2] ** 2).sum(axis=1))
    hit = np.flatnonzero((depth > 0) & (distance < _FADE_END))
    hit_points = np.ascontiguousarray(points[hit].astype(np.float32).T)
    shift = pixel_shifts(rows[hit], columns[hit])
    full_light = sum(lamp.power * lamp.direction[2] for lamp in scene.lamps)
    # The light that is missing in each pixel, as a share of all light: that of the sky, and the key light.
    shades = np.zeros((2, len(rays)), dtype=np.float32)
    for lamp in scene.lamps:
        is_dark = ~lamp.reaches(hit_points, shift, _SHADOW_SLACK)
        shades[int(lamp.is_key), hit] += is_dark * np.float32(lamp.power * lamp.direction[2] / full_light)
    # Far shadows fade, so that none is cut off at the picture's edge.
    shades[:, hit] *= np.clip((_FADE_END - distance[hit]) / (_FADE_END - _FADE_START), 0.0, 1.0)
    sky_shade, key_shade = shades.reshape(2, height, width)
    blurred_shade = blur(sky_shade, _SKY_BLUR) + blur(key_shade, _KEY_BLUR)
    shade = enlarge(blurred_shade, _SHADOW_PIXEL_SIZE)[:image_height, :image_width]
    brightness = 1.0 - np.float32(_SHADOW_DARKNESS) * shade[:, :, None]
    return np.asarray(_BACKGROUND * brightness, dtype=np.float32)
