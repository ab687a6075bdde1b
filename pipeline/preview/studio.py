"""A picture of a robot in a studio: a calm ground that fades into the background, a soft shadow."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.preview.camera import Camera, framing, turned
from pipeline.preview.compiled import Seen
from pipeline.preview.light import Lamp, key_lamps, occluders, sky_lamps
from pipeline.preview.pixels import blurred, enlarged, linear, reduced, scattered, shown
from stages.mesh.view.raster import Corners, Indices, Numbers, Pixels, seen

_FINER = 2
"""Pixels that are drawn for one of the picture, each way."""

_BACKGROUND = np.array([0.905, 0.916, 0.928])
"""sRGB."""

_SHADOW = 0.62
"""How dark the ground is where no light reaches it."""

_BOUNCE = 0.42
"""The light that comes back from the ground."""

_EXPOSURE = 0.94
_GLOSS, _SHINE = 0.055, 48.0
_RIM = 0.16
_AT_ONCE = 1 << 18  # points
_OPAQUE = 0.99
_COARSE = 6
"""Pixels of what is drawn for one of the ground's shadow."""
_LEVELS = 64
_KEY_ASIDE = np.radians(-22.0)
_KEY_ABOVE = 1.6
"""Where the key light is: to the left of the camera, and above, of 1 towards it."""
_NEAR, _FAR = 1.0, 2.1
"""Where shadows on the ground begin to fade, and are gone."""


@dataclass(frozen=True, slots=True, eq=False)
class LitRobot:
    """A robot within 1 of the origin, seen from `backward` (3,), with its `lamps`, of which the key light is
    towards `key` (3,). `throwing` (n, 3, 3): the triangles that throw shadows; `sky`: the lamps that stay
    where they are while the robot turns; `floor`: the height of the ground; `albedo` (m, 3)."""

    seen: Seen
    corners: Corners
    throwing: Corners
    backward: Numbers
    sky: list[Lamp]
    lamps: list[Lamp]
    key: Numbers
    floor: float
    albedo: Numbers


def studio(robot: Seen) -> LitRobot:
    """Sets a robot up, whatever its size."""
    points = robot.corners.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    radius = 1.001 * float(np.sqrt(((points - middle) ** 2).sum(axis=1).max())) or 1.0
    corners = (robot.corners - middle) / radius
    floor = (robot.floor - float(middle[2])) / radius
    albedo = 0.018 + 0.94 * linear(np.clip(robot.colours[:, :3], 0.0, 1.0))
    throwing = occluders(corners)
    sky = sky_lamps(throwing)
    unlit = LitRobot(robot, corners, throwing, robot.backward, sky, [], robot.backward, floor, albedo)
    return turned_by(unlit, 0.0)


def turned_by(scene: LitRobot, angle: float) -> LitRobot:
    """The robot turned by an angle [rad] before a camera and a key light that stay where they are."""
    backward = turned(scene.seen.backward, -angle)
    flat = np.array([backward[0], backward[1], 0.0])
    length = float(np.linalg.norm(flat))
    front = flat / length if length > 1e-6 else np.array([1.0, 0.0, 0.0])
    # From the left of the camera, little enough that the front is lit too, and above.
    key = turned(front, _KEY_ASIDE) + np.array([0.0, 0.0, _KEY_ABOVE])
    key /= np.linalg.norm(key)
    return replace(scene, backward=backward, key=key, lamps=[*key_lamps(key, scene.throwing), *scene.sky])


def picture(scene: LitRobot, width: int, height: int, framed: Numbers | None = None) -> Pixels:
    """(height, width, 3): the robot, so that it, or the points `framed` (n, 3), fill the picture."""
    points = scene.corners.reshape(-1, 3) if framed is None else framed
    return rendered(scene, framing(points, scene.backward, _FINER * width, _FINER * height))


def swept(scene: LitRobot) -> Numbers:
    """(n, 3): points around all that the robot reaches while it turns."""
    points = scene.corners.reshape(-1, 3)
    reach = np.sqrt((points[:, :2] ** 2).sum(axis=1))
    low, high = points[:, 2].min(), points[:, 2].max()
    level = np.minimum((points[:, 2] - low) / max(high - low, 1e-12) * _LEVELS, _LEVELS - 1).astype(np.intp)
    rings = []
    for one in np.unique(level):
        some = level == one
        angles = np.linspace(0.0, 2 * np.pi, 72, endpoint=False)
        ring = np.stack([np.cos(angles), np.sin(angles)], axis=1) * reach[some].max()
        for z in (points[some, 2].min(), points[some, 2].max()):
            rings.append(np.column_stack([ring, np.full(len(ring), z)]))
    return np.concatenate(rings)


def rendered(scene: LitRobot, camera: Camera) -> Pixels:
    """What a camera sees, whose picture is `_FINER` times as fine as the one that is made. Of what can be
    seen through, one layer is drawn over what is opaque."""
    placed = camera.projected(scene.corners)
    image = _ground(scene, camera)
    opaque = np.flatnonzero(scene.seen.colours[:, 3] >= _OPAQUE)
    if 0 < len(opaque) < len(placed):
        behind = seen(placed[opaque], camera.width, camera.height)
        _paint(image, scene, camera, np.where(behind < 0, -1, opaque[behind]))
    _paint(image, scene, camera, seen(placed, camera.width, camera.height))
    return reduced(image, _FINER)


def _paint(image: Numbers, scene: LitRobot, camera: Camera, which: Indices) -> None:
    """Draws over an image the triangle that is seen in each pixel, -1 for none."""
    every = np.flatnonzero(which >= 0)
    for start in range(0, len(every), _AT_ONCE):
        rows, columns = np.divmod(every[start : start + _AT_ONCE], camera.width)
        triangle = which[rows, columns]
        alpha = scene.seen.colours[triangle, 3:4]
        alpha = np.where(alpha >= _OPAQUE, 1.0, alpha)
        found = _surface(scene, camera, triangle, rows, columns)
        image[rows, columns] = alpha * found + (1.0 - alpha) * image[rows, columns]


def _surface(scene: LitRobot, camera: Camera, triangle: Indices, rows: Indices, columns: Indices) -> Numbers:
    """(n, 3): the colours of points of the robot, in sRGB."""
    rays = camera.rays(columns + 0.5, rows + 0.5)
    points, shares = _met(scene.corners, triangle, camera.position, rays)
    normals = (scene.seen.normals[triangle] * shares[:, :, None]).sum(axis=1)
    toward = -rays / np.sqrt((rays * rays).sum(axis=1, keepdims=True))
    normals = _facing(normals, toward)
    albedo = _albedo(scene, triangle, shares)
    shift = scattered(rows, columns)
    raised = (points + 0.006 * normals).astype(np.float32)
    light = np.zeros(len(points), dtype=np.float32)
    key = np.zeros_like(light)
    single = normals.astype(np.float32)
    for lamp in scene.lamps:
        lit = single @ (lamp.direction * lamp.power).astype(np.float32)
        np.maximum(lit, 0.0, out=lit)
        lit *= lamp.reaches(raised, shift, 0.006)
        light += lit
        if lamp.is_key:
            key += lit
    half = toward + scene.key
    half /= np.sqrt((half * half).sum(axis=1, keepdims=True))
    gloss = key * np.clip((half * normals).sum(axis=1), 0.0, None) ** _SHINE
    light += _BOUNCE * (0.62 - 0.38 * normals[:, 2])
    rim = (1.0 - np.clip((toward * normals).sum(axis=1), 0.0, 1.0)) ** 4
    total = albedo * light[:, None] / np.pi * 1.9
    total += (_GLOSS * gloss * 5 + _RIM * rim * light * 0.35)[:, None]
    return shown(_EXPOSURE * total)


def _met(corners: Corners, triangle: Indices, position: Numbers, rays: Numbers) -> tuple[Numbers, Numbers]:
    """Where rays meet the planes of their triangles, and the shares of the three corners there."""
    a, b, c = np.moveaxis(corners[triangle], 1, 0)
    ab, ac = b - a, c - a
    normal = np.cross(ab, ac)
    along = (rays * normal).sum(axis=1)
    depth = np.divide(
        ((a - position) * normal).sum(axis=1), along, out=np.zeros_like(along), where=along != 0
    )
    points = position + depth[:, None] * rays
    area = (normal * normal).sum(axis=1)
    to = points - a
    of_b = np.divide((np.cross(to, ac) * normal).sum(axis=1), area, out=np.zeros_like(area), where=area > 0)
    of_c = np.divide((np.cross(ab, to) * normal).sum(axis=1), area, out=np.zeros_like(area), where=area > 0)
    of_b, of_c = np.clip(of_b, 0.0, 1.0), np.clip(of_c, 0.0, 1.0)
    shares = np.stack([np.clip(1.0 - of_b - of_c, 0.0, 1.0), of_b, of_c], axis=1)
    return (corners[triangle] * shares[:, :, None]).sum(axis=1), shares


def _facing(normals: Numbers, toward: Numbers) -> Numbers:
    """Unit normals on the viewer's side, whichever way the triangles turn."""
    lengths = np.sqrt((normals * normals).sum(axis=1, keepdims=True))
    unit = np.where(lengths > 1e-9, normals / np.maximum(lengths, 1e-9), toward)
    away = (unit * toward).sum(axis=1) < 0
    return np.asarray(np.where(away[:, None], -unit, unit))


def _albedo(scene: LitRobot, triangle: Indices, shares: Numbers) -> Numbers:
    """(n, 3): what share of the light is given back, of each colour."""
    found = scene.albedo[triangle]
    of = scene.seen.image[triangle]
    for number, image in enumerate(scene.seen.images):
        some = np.flatnonzero(of == number)
        if len(some):
            at = (scene.seen.places[triangle[some]] * shares[some, :, None]).sum(axis=1) % 1.0
            height, width = image.shape[:2]
            column = np.minimum((at[:, 0] * width).astype(np.intp), width - 1)
            row = np.minimum((at[:, 1] * height).astype(np.intp), height - 1)
            found[some] *= linear(image[row, column])
    return found


def _ground(scene: LitRobot, camera: Camera) -> Numbers:
    """(height, width, 3): the background, with the shadow on the ground, in sRGB."""
    height, width = -(-camera.height // _COARSE), -(-camera.width // _COARSE)
    rows, columns = np.meshgrid(np.arange(height), np.arange(width), indexing="ij")
    rays = camera.rays((columns.ravel() + 0.5) * _COARSE, (rows.ravel() + 0.5) * _COARSE)
    depth = np.divide(
        scene.floor - camera.position[2], rays[:, 2], out=np.full(len(rays), -1.0), where=rays[:, 2] < -1e-6
    )
    hit = np.flatnonzero(depth > 0)
    points = camera.position + depth[hit, None] * rays[hit]
    single = points.astype(np.float32)
    shift = scattered(rows.ravel()[hit], columns.ravel()[hit])
    full = sum(lamp.power * lamp.direction[2] for lamp in scene.lamps)
    shades = np.zeros((2, len(rays)))
    for lamp in scene.lamps:
        dark = ~lamp.reaches(single, shift, 0.003)
        shades[int(lamp.is_key), hit] += dark * (lamp.power * lamp.direction[2] / full)
    # Far shadows fade, so that none ends at the picture's edge.
    away = np.sqrt((points[:, :2] ** 2).sum(axis=1))
    shades[:, hit] *= np.clip((_FAR - away) / (_FAR - _NEAR), 0.0, 1.0)
    of_sky, of_key = shades.reshape(2, height, width)
    shade = enlarged(blurred(of_sky, 4) + blurred(of_key, 3), _COARSE)[: camera.height, : camera.width]
    return np.asarray(_BACKGROUND * (1.0 - _SHADOW * shade[:, :, None]))
