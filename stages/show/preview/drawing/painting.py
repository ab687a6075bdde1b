"""Paints the robot in a studio: with a soft shadow on a ground that fades into the background."""

import functools
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from linkwright.stages.show.preview.camera import Camera, framing
from linkwright.stages.show.preview.drawing.faces import Faces
from linkwright.stages.show.preview.drawing.pixels import blur, enlarge, pixel_shifts
from linkwright.stages.show.preview.drawing.studio import LitRobot
from linkwright.stages.show.preview.drawing.vectors import dot
from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Indices, Numbers, Pixels, nearest_triangles

Flags = npt.NDArray[np.bool_]

SAMPLES_PER_SIDE = 2
"""Number of samples along each side of a pixel: the camera's picture is this many times as wide and as high
as the final picture."""

_BACKGROUND = np.array([0.905, 0.916, 0.928], dtype=np.float32)
"""Colour of the background in sRGB."""

_SHADOW_DARKNESS = 0.62
"""Share of the background's colour that the ground loses where no light reaches it."""

_MIN_OPAQUE_ALPHA = 0.99
"""Faces with at least this opacity count as opaque."""

_MIN_SAME_COLOUR_COSINE = np.float32(0.96)
"""Cosine of the largest angle between faces of a geom that share a colour within a pixel."""

_MIN_DESCENT = 1e-6
"""Rays that descend by less than this per unit of depth count as missing the ground."""

_SHADOW_PIXEL_SIZE = 3
"""Width of a pixel of the ground's shadow, in pixels of the final picture."""

_SHADOW_SLACK = 0.5
"""Depth behind a lamp's nearest point, in pixels of the lamp, up to which the ground is still lit."""

_SKY_BLUR, _KEY_BLUR = 4, 3
"""Half widths of the blur of the shadows of sky and key light, in pixels of the ground's shadow."""

_FADE_START, _FADE_END = 1.0, 2.1
"""Distances from the origin, in radii of the robot, at which shadows on the ground begin to fade, and at
which they are gone."""


class _DrawnSamples(NamedTuple):
    """The samples whose colours are computed (n,)."""

    pixel_rows: Indices
    """Row of each sample's pixel among the pixels that show a face."""
    sample_indices: Indices
    """Index of each sample in its pixel, row by row."""
    shares: Single
    """Share of its pixel that each sample colours."""


def draw_picture(robot: LitRobot, width: int, height: int, points: Numbers | None = None) -> Pixels:
    """Draws a picture (height, width, 3) that the robot fills, or that the `points` (n, 3) fill if they are
    not None. `width`, `height` [pixels]."""
    shown_points = robot.corners.reshape(-1, 3) if points is None else points
    size = SAMPLES_PER_SIDE * width, SAMPLES_PER_SIDE * height
    return render(robot, framing(shown_points, robot.backward, *size))


def render(robot: LitRobot, camera: Camera) -> Pixels:
    """Draws what a camera sees (height, width, 3); each pixel merges `SAMPLES_PER_SIDE`² pixels of the
    camera.

    Only the nearest layer of transparent faces is drawn over the opaque faces.
    """
    corners = camera.projected(robot.corners)
    image = _ground(robot, camera)
    alpha = robot.surface.colours[robot.surface.geom, 3]
    opaque = np.flatnonzero(alpha >= _MIN_OPAQUE_ALPHA)
    # Opaque faces are drawn first, so that they are visible through transparent ones.
    if 0 < len(opaque) < len(corners):
        nearest_opaque = nearest_triangles(corners[opaque], camera.width, camera.height)
        _paint(image, robot, camera, corners, np.where(nearest_opaque < 0, -1, opaque[nearest_opaque]))
    _paint(image, robot, camera, corners, nearest_triangles(corners, camera.width, camera.height))
    return np.asarray(np.rint(image * 255.0).astype(np.uint8))


def _paint(image: Single, robot: LitRobot, camera: Camera, corners: Single, shown_triangles: Indices) -> None:
    """Draws triangles over an image (height, width, 3) in sRGB.

    `corners` (m, 3, 3): the robot's triangles in the camera's picture; `shown_triangles`: the triangle that
    each sample shows, or -1; a sample is a pixel of the camera's picture.
    """
    side = SAMPLES_PER_SIDE
    width = image.shape[1]
    # One array per sample position in a pixel, row by row: the triangle that this sample shows, for all
    # pixels.
    triangles_by_sample = [
        shown_triangles[row::side, column::side].ravel() for row in range(side) for column in range(side)
    ]
    pixels = np.flatnonzero(functools.reduce(np.maximum, triangles_by_sample) >= 0)
    if not len(pixels):
        return
    triangle_of_sample = np.stack(
        [sample_triangles[pixels] for sample_triangles in triangles_by_sample], axis=1
    )
    visible_triangles, face_of_sample = _number_faces(triangle_of_sample, len(corners))
    faces = Faces(robot, corners, visible_triangles)
    samples = _drawn_samples(face_of_sample, faces)
    face_indices = face_of_sample[samples.pixel_rows, samples.sample_indices]
    rows, columns = np.divmod(pixels[samples.pixel_rows], width)
    sample_rows = side * rows + samples.sample_indices // side
    sample_columns = side * columns + samples.sample_indices % side
    # Half a pixel further is the middle of the sample.
    colours = faces.colours(camera, face_indices, sample_columns + 0.5, sample_rows + 0.5, side)
    alpha = robot.surface.colours[robot.surface.geom[visible_triangles], 3][face_indices]
    _blend(image.reshape(-1, 3), pixels, samples, colours, alpha)


def _number_faces(triangle_of_sample: Indices, triangle_count: int) -> tuple[Indices, Indices]:
    """Returns the visible triangles, sorted, and for each sample its face: the index of its triangle among
    them, or -1. Only visible triangles get colours."""
    is_visible = np.zeros(triangle_count, dtype=np.bool_)
    is_visible[triangle_of_sample[triangle_of_sample >= 0]] = True
    face_of_triangle = np.cumsum(is_visible) - 1
    face_of_sample = np.where(triangle_of_sample >= 0, face_of_triangle[triangle_of_sample], -1)
    return np.flatnonzero(is_visible), face_of_sample


def _blend(
    flat_image: Single, pixels: Indices, samples: _DrawnSamples, colours: Single, alpha: Single
) -> None:
    """Draws the colours (n, 3) of samples, with their opacities `alpha` (n,), over the `pixels` of an image
    (height x width, 3)."""
    weight = (np.where(alpha >= _MIN_OPAQUE_ALPHA, 1.0, alpha) * samples.shares).astype(np.float32)
    pixel_count = len(pixels)
    coverage = np.bincount(samples.pixel_rows, weight, minlength=pixel_count).astype(np.float32)
    flat_image[pixels] *= (1.0 - coverage)[:, None]
    for channel in range(3):
        channel_weight = weight * colours[:, channel]
        flat_image[pixels, channel] += np.bincount(samples.pixel_rows, channel_weight, minlength=pixel_count)


def _drawn_samples(face_of_sample: Indices, faces: Faces) -> _DrawnSamples:
    """Chooses the samples whose colours are computed: of a pixel whose samples show one surface, the first
    sample with a face; of other pixels, every sample with a face.

    `face_of_sample` (pixels, samples): the face that each sample shows, or -1.
    """
    pixel_count, sample_count = face_of_sample.shape
    has_face = face_of_sample >= 0
    first_sample = has_face.argmax(axis=1)
    first_face = face_of_sample[np.arange(pixel_count), first_sample]
    shows_several = np.zeros(pixel_count, dtype=np.bool_)
    for sample_index in range(sample_count):
        differing = np.flatnonzero(
            has_face[:, sample_index] & (face_of_sample[:, sample_index] != first_face)
        )
        differing_face, reference_face = face_of_sample[differing, sample_index], first_face[differing]
        cosine = dot(faces.normals[differing_face], faces.normals[reference_face])
        has_same_geom = faces.geom[differing_face] == faces.geom[reference_face]
        is_same = has_same_geom & (cosine > _MIN_SAME_COLOUR_COSINE)
        shows_several[differing[~is_same]] = True
    plain_pixels = np.flatnonzero(~shows_several)
    mixed_pixels, mixed_samples = np.nonzero(has_face & shows_several[:, None])
    plain_shares = np.count_nonzero(has_face, axis=1)[plain_pixels] / sample_count
    mixed_shares = np.full(len(mixed_pixels), 1 / sample_count)
    return _DrawnSamples(
        np.concatenate([plain_pixels, mixed_pixels]),
        np.concatenate([first_sample[plain_pixels], mixed_samples]),
        np.concatenate([plain_shares, mixed_shares]).astype(np.float32),
    )


def _ground(robot: LitRobot, camera: Camera) -> Single:
    """Draws the background (height, width, 3) in sRGB, with the robot's shadow on the ground.

    The shadow is soft, so it is computed for larger pixels, and then enlarged.
    """
    image_width, image_height = camera.width // SAMPLES_PER_SIDE, camera.height // SAMPLES_PER_SIDE
    # Both are rounded up.
    width, height = -(-image_width // _SHADOW_PIXEL_SIZE), -(-image_height // _SHADOW_PIXEL_SIZE)
    sky_shade, key_shade = _shades(robot, camera, width, height).reshape(2, height, width)
    blurred_shade = blur(sky_shade, _SKY_BLUR) + blur(key_shade, _KEY_BLUR)
    shade = enlarge(blurred_shade, _SHADOW_PIXEL_SIZE)[:image_height, :image_width]
    brightness = 1.0 - np.float32(_SHADOW_DARKNESS) * shade[:, :, None]
    return np.asarray(_BACKGROUND * brightness, dtype=np.float32)


def _shades(robot: LitRobot, camera: Camera, width: int, height: int) -> Single:
    """Returns the light that the ground misses (2, height * width), as a share of all light, for each pixel
    of the shadow: first the light of the sky, then the key light."""
    rows, columns = np.divmod(np.arange(height * width), width)
    points, is_ground = _ground_points(robot, camera, rows, columns)
    # The robot has the radius 1 about the origin (`studio`), so distances are in radii.
    distances = np.sqrt((points[:, :2] ** 2).sum(axis=1))
    pixels = np.flatnonzero(is_ground & (distances < _FADE_END))
    ground_points = np.ascontiguousarray(points[pixels].astype(np.float32).T)
    shifts = pixel_shifts(rows[pixels], columns[pixels])
    full_light = sum(lamp.power * lamp.direction[2] for lamp in robot.lamps)
    shades = np.zeros((2, len(points)), dtype=np.float32)
    for lamp in robot.lamps:
        is_dark = ~lamp.reaches(ground_points, shifts, _SHADOW_SLACK)
        shades[int(lamp.is_key), pixels] += is_dark * np.float32(lamp.power * lamp.direction[2] / full_light)
    # Far shadows fade, so that none is cut off at the picture's edge.
    shades[:, pixels] *= np.clip((_FADE_END - distances[pixels]) / (_FADE_END - _FADE_START), 0.0, 1.0)
    return shades


def _ground_points(robot: LitRobot, camera: Camera, rows: Indices, columns: Indices) -> tuple[Numbers, Flags]:
    """Returns the points (n, 3) of the ground at pixels of its shadow, and whether each pixel shows the
    ground. If it does not, its point has no meaning."""
    step = SAMPLES_PER_SIDE * _SHADOW_PIXEL_SIZE
    rays = camera.rays((columns + 0.5) * step, (rows + 0.5) * step)
    goes_down = rays[:, 2] < -_MIN_DESCENT
    # -1: behind the camera, for rays that never meet the ground.
    depth = np.divide(
        robot.floor - camera.position[2], rays[:, 2], out=np.full(len(rays), -1.0), where=goes_down
    )
    return camera.position + depth[:, None] * rays, depth > 0
