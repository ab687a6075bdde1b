"""Computes the colours of points on the visible triangles in the light of the lamps."""

import itertools
from collections.abc import Sequence

import numpy as np

from linkwright.stages.show.preview.camera import Camera
from linkwright.stages.show.preview.drawing.creases import normals_of
from linkwright.stages.show.preview.drawing.pixels import light_of_srgb, pixel_shifts, srgb_of_light
from linkwright.stages.show.preview.drawing.studio import LitRobot
from linkwright.stages.show.preview.drawing.vectors import cross, dot, interpolate, unit_vectors
from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Indices, Numbers

_BOUNCE = 0.42
"""Strength of the light that the ground reflects."""

_EXPOSURE = 0.94
"""Factor of all light before it is converted for the screen."""

_GLOSS, _SHINE = 0.055, 48.0
"""Strength and exponent of the highlights (Blinn and Phong)."""

_RIM = 0.16
"""Strength of the light on surfaces that are seen edge-on."""

_TEST_HEIGHT, _SHADOW_SLACK = 2.0, 1.5
"""Height above the surface at which light is tested, and the depth behind a lamp's nearest point up to which
a point is still lit, both in the lamp's pixels. They keep a surface from casting a shadow on itself."""

_SHIFTS = 4
"""Number of shift patterns that the lamps use in turn."""


class Faces:
    """The visible triangles, whose colours are computed point by point.

    `geom` (n,): the geom of each triangle; `normals` (n, 3): the unit normal of each triangle.
    """

    def __init__(self, scene: LitRobot, placed_corners: Single, selected: Indices) -> None:
        surface = scene.surface
        self._scene = scene
        self._corners = scene.corners[selected]
        self._corner_normals = normals_of(scene.corners, surface.geom, selected)
        self._places = surface.places[selected] if len(surface.places) else None
        self.geom = surface.geom[selected]
        self._albedo = scene.albedo[self.geom]
        a, b, c = np.moveaxis(self._corners, 1, 0)
        self.normals = unit_vectors(cross(b - a, c - a))
        self._shares = _shares_of(placed_corners[selected])

    def colours(self, camera: Camera, face: Indices, right: Numbers, down: Numbers, finer: int) -> Single:
        """Returns the sRGB colours (n, 3) of the faces at places (n,) in the camera's picture, which has
        `finer` times as many pixels each way as the final picture."""
        scene = self._scene
        x, y = right.astype(np.float32)[:, None], down.astype(np.float32)[:, None]
        first = self._shares[face]
        shares = first[:, 0] * x + first[:, 1] * y + first[:, 2]
        np.maximum(shares, 0.0, out=shares)
        shares /= np.maximum(shares[:, 0] + shares[:, 1] + shares[:, 2], np.float32(1e-30))[:, None]
        points = interpolate(shares, self._corners[face])
        toward = unit_vectors(camera.position.astype(np.float32) - points)
        normals = _facing(interpolate(shares, self._corner_normals[face]), toward)
        row, column = down.astype(np.int32) // finer, right.astype(np.int32) // finer
        light, key = self._light(
            points, normals, [pixel_shifts(row, column, turn) for turn in range(_SHIFTS)]
        )
        half = unit_vectors(toward + scene.key.astype(np.float32))
        gloss = key * np.maximum(dot(half, normals), 0.0) ** np.float32(_SHINE)
        light += np.float32(_BOUNCE) * (np.float32(0.62) - np.float32(0.38) * normals[:, 2])
        rim = (1.0 - np.clip(dot(toward, normals), 0.0, 1.0)) ** 4
        total = self._reflected(face, shares) * (light * np.float32(1.9 / np.pi))[:, None]
        total += (np.float32(_GLOSS * 5) * gloss + np.float32(_RIM * 0.35) * rim * light)[:, None]
        return srgb_of_light(np.float32(_EXPOSURE) * total).astype(np.float32)

    def _light(self, points: Single, normals: Single, shifts: Sequence[Single]) -> tuple[Single, Single]:
        """Returns the light (n,) of all lamps that reaches points, and the light (n,) of the key light alone.
        `shifts`: shifts of the points' places for the lamps in turn; a common shift would show as a pattern.
        """
        raised_points = {
            pixel: np.ascontiguousarray((points + np.float32(_TEST_HEIGHT * pixel) * normals).T)
            for pixel in {lamp.pixel for lamp in self._scene.lamps}
        }
        light = np.zeros(len(points), dtype=np.float32)
        key = np.zeros_like(light)
        for lamp, shift in zip(self._scene.lamps, itertools.cycle(shifts), strict=False):
            lamp_light = normals @ (lamp.direction * np.float32(lamp.power))
            np.maximum(lamp_light, 0.0, out=lamp_light)
            lamp_light *= lamp.reaches(raised_points[lamp.pixel], shift, _SHADOW_SLACK)
            light += lamp_light
            if lamp.is_key:
                key += lamp_light
        return light, key

    def _reflected(self, face: Indices, shares: Single) -> Single:
        """Returns the share (n, 3) of red, green and blue light that points reflect."""
        reflected = self._albedo[face]
        surface = self._scene.surface
        if self._places is None:
            return reflected
        image_of_face = surface.image[self.geom[face]]
        for number, image in enumerate(surface.images):
            with_image = np.flatnonzero(image_of_face == number)
            if len(with_image):
                place = interpolate(shares[with_image], self._places[face[with_image]]) % 1.0
                height, width = image.shape[:2]
                column = np.minimum((place[:, 0] * width).astype(np.intp), width - 1)
                row = np.minimum((place[:, 1] * height).astype(np.intp), height - 1)
                reflected[with_image] *= light_of_srgb(image[row, column]).astype(np.float32)
        return reflected


def _shares_of(picture_corners: Single) -> Single:
    """Returns a linear function of the place in the picture for each corner of triangles (n, 3, 3) in the
    picture: the change of the corner's share to the right and downwards, and its value at the origin.

    They are the shares in the picture times the corner's nearness, and so the shares in space, up to a common
    factor.
    """
    a, b, c = np.moveaxis(picture_corners.astype(np.float64), 1, 0)
    by_corner = []
    for second, third, first in ((b, c, a), (c, a, b), (a, b, c)):
        right, down = second[:, 1] - third[:, 1], third[:, 0] - second[:, 0]
        at_origin = -right * second[:, 0] - down * second[:, 1]
        by_corner.append(np.stack([right, down, at_origin], axis=1) * first[:, 2:3])
    shares = np.stack(by_corner, axis=2)
    turn = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    shares /= np.where(np.abs(turn) > 1e-12, turn, 1.0)[:, None, None]
    return shares.astype(np.float32)


def _facing(normals: Single, toward: Single) -> Single:
    """Turns normals to the viewer's side and normalizes them; a zero normal becomes the direction to the
    viewer."""
    facing = unit_vectors(normals)
    zero_normals = np.flatnonzero(dot(facing, facing) < 0.5)
    facing[zero_normals] = toward[zero_normals]
    away = np.flatnonzero(dot(facing, toward) < 0)
    facing[away] *= -1
    return np.asarray(facing)
