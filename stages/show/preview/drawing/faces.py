"""Triangles as they are seen: each point in the light that reaches it, as a screen shows it."""

import itertools
from collections.abc import Sequence

import numpy as np

from linkwright.stages.show.preview.camera import Camera
from linkwright.stages.show.preview.drawing.creases import normals_of
from linkwright.stages.show.preview.drawing.pixels import linear, scattered, shown
from linkwright.stages.show.preview.drawing.studio import LitRobot
from linkwright.stages.show.preview.drawing.vectors import cross, dot, mixed, unit
from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Indices, Numbers

_BOUNCE = 0.42
"""The light that comes back from the ground."""

_EXPOSURE = 0.94
_GLOSS, _SHINE = 0.055, 48.0
_RIM = 0.16
_RAISED, _SLACK = 2.0, 1.5
"""How far above the surface it is asked which light reaches it, and how far behind what a lamp sees a point
is still lit, in the lamp's pixels."""

_SHIFTS = 4


class Faces:
    """The triangles that are seen, of which each point is drawn.

    `geom` (n,); `flat` (n, 3): unit normals.
    """

    def __init__(self, scene: LitRobot, placed: Single, which: Indices) -> None:
        surface = scene.surface
        self._scene = scene
        self._corners = scene.corners[which]
        self._normals = normals_of(scene.corners, surface.geom, which)
        self._places = surface.places[which] if len(surface.places) else None
        self.geom = surface.geom[which]
        self._albedo = scene.albedo[self.geom]
        a, b, c = np.moveaxis(self._corners, 1, 0)
        self.flat = unit(cross(b - a, c - a))
        self._shares = _shares_of(placed[which])

    def colours(self, camera: Camera, face: Indices, right: Numbers, down: Numbers, finer: int) -> Single:
        """(n, 3): the colours of the faces at places in the camera's picture, which is `finer` than the one
        that is made, in sRGB."""
        scene = self._scene
        x, y = right.astype(np.float32)[:, None], down.astype(np.float32)[:, None]
        first = self._shares[face]
        shares = first[:, 0] * x + first[:, 1] * y + first[:, 2]
        np.maximum(shares, 0.0, out=shares)
        shares /= np.maximum(shares[:, 0] + shares[:, 1] + shares[:, 2], np.float32(1e-30))[:, None]
        points = mixed(shares, self._corners[face])
        toward = unit(camera.position.astype(np.float32) - points)
        normals = _facing(mixed(shares, self._normals[face]), toward)
        row, column = down.astype(np.int32) // finer, right.astype(np.int32) // finer
        light, key = self._light(points, normals, [scattered(row, column, turn) for turn in range(_SHIFTS)])
        half = unit(toward + scene.key.astype(np.float32))
        gloss = key * np.maximum(dot(half, normals), 0.0) ** np.float32(_SHINE)
        light += np.float32(_BOUNCE) * (np.float32(0.62) - np.float32(0.38) * normals[:, 2])
        rim = (1.0 - np.clip(dot(toward, normals), 0.0, 1.0)) ** 4
        total = self._given_back(face, shares) * (light * np.float32(1.9 / np.pi))[:, None]
        total += (np.float32(_GLOSS * 5) * gloss + np.float32(_RIM * 0.35) * rim * light)[:, None]
        return shown(np.float32(_EXPOSURE) * total).astype(np.float32)

    def _light(self, points: Single, normals: Single, shifts: Sequence[Single]) -> tuple[Single, Single]:
        """(n,): all light of lamps that reaches points, and that of the key light. `shifts`: of the lamps in
        turn, which would show as a pattern if all had one."""
        raised = {
            pixel: np.ascontiguousarray((points + np.float32(_RAISED * pixel) * normals).T)
            for pixel in {lamp.pixel for lamp in self._scene.lamps}
        }
        light = np.zeros(len(points), dtype=np.float32)
        key = np.zeros_like(light)
        for lamp, shift in zip(self._scene.lamps, itertools.cycle(shifts), strict=False):
            lit = normals @ (lamp.direction * np.float32(lamp.power))
            np.maximum(lit, 0.0, out=lit)
            lit *= lamp.reaches(raised[lamp.pixel], shift, _SLACK)
            light += lit
            if lamp.is_key:
                key += lit
        return light, key

    def _given_back(self, face: Indices, shares: Single) -> Single:
        """(n, 3): what share of the light is given back, of each colour."""
        found = self._albedo[face]
        surface = self._scene.surface
        if self._places is None:
            return found
        which = surface.image[self.geom[face]]
        for number, image in enumerate(surface.images):
            some = np.flatnonzero(which == number)
            if len(some):
                at = mixed(shares[some], self._places[face[some]]) % 1.0
                height, width = image.shape[:2]
                column = np.minimum((at[:, 0] * width).astype(np.intp), width - 1)
                row = np.minimum((at[:, 1] * height).astype(np.intp), height - 1)
                found[some] *= linear(image[row, column]).astype(np.float32)
        return found


def _shares_of(placed: Single) -> Single:
    """(n, 3, 3): of each triangle as it is placed in the picture three numbers for each corner: how the share
    of the corner in a point changes to the right and downwards, and what it is at the origin. They are the
    shares in the picture times how near the corner is, and so in space, but for a common factor."""
    a, b, c = np.moveaxis(placed.astype(np.float64), 1, 0)
    found = []
    for one, two, near in ((b, c, a), (c, a, b), (a, b, c)):
        right, down = one[:, 1] - two[:, 1], two[:, 0] - one[:, 0]
        found.append(np.stack([right, down, -right * one[:, 0] - down * one[:, 1]], axis=1) * near[:, 2:3])
    both = np.stack(found, axis=2)
    turn = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    both /= np.where(np.abs(turn) > 1e-12, turn, 1.0)[:, None, None]
    return both.astype(np.float32)


def _facing(normals: Single, toward: Single) -> Single:
    """Unit normals on the viewer's side, whichever way the triangles turn."""
    found = unit(normals)
    lost = np.flatnonzero(dot(found, found) < 0.5)
    found[lost] = toward[lost]
    away = np.flatnonzero(dot(found, toward) < 0)
    found[away] *= -1
    return np.asarray(found)
