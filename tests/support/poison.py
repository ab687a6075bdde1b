"""Meshes that no collider can be made of, or only with care."""

from typing import NamedTuple

import numpy as np
from trimesh.creation import annulus, box, icosphere


class Mesh(NamedTuple):
    """Points (n, 3) [m] and triangles (m, 3)."""

    vertices: np.ndarray
    faces: np.ndarray


def of(mesh):
    return Mesh(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64))


def together(*meshes):
    starts = np.cumsum([0, *(len(points) for points, _ in meshes)])
    faces = [triangles + start for (_, triangles), start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([points for points, _ in meshes]), np.concatenate(faces))


def shifted(mesh, *by):
    return Mesh(mesh[0] + np.array(by), mesh[1])


RING = of(annulus(0.02, 0.03, 0.02, sections=24))


def _not_manifold():
    """A ring with fins: three and four triangles at an edge."""
    points, triangles = RING
    tips = points[triangles[:6, 0]] + [0.0, 0.0, 0.01]
    fins = np.stack([triangles[:6, 0], triangles[:6, 1], len(points) + np.arange(6)], axis=1)
    return Mesh(np.concatenate([points, tips]), np.concatenate([triangles, fins]))


def _half_inverted():
    triangles = RING[1].copy()
    triangles[::2] = triangles[::2, ::-1]
    return Mesh(RING[0], triangles)


def _nan():
    points = RING[0].copy()
    points[5, 1] = np.nan
    return Mesh(points, RING[1])


def _self_intersecting():
    """A tube along a knot that runs through itself."""
    turns = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    path = 0.03 * np.stack([np.sin(turns), np.sin(2 * turns), 0 * turns], axis=1)
    around = np.linspace(0, 2 * np.pi, 10, endpoint=False)
    along = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    up = np.array([0.0, 0, 1])
    side = np.cross(along, up)
    points = path[:, None] + 0.008 * (
        np.cos(around)[None, :, None] * side[:, None] + np.sin(around)[None, :, None] * up
    )
    i, j = np.meshgrid(np.arange(60), np.arange(10), indexing="ij")
    a, b = i * 10 + j, i * 10 + (j + 1) % 10
    c, d = (i + 1) % 60 * 10 + (j + 1) % 10, (i + 1) % 60 * 10 + j
    triangles = np.concatenate([np.stack(half, axis=-1).reshape(-1, 3) for half in ([a, b, c], [a, c, d])])
    return Mesh(points.reshape(-1, 3), triangles)


def _tangle():
    """Triangles at random, from end to end of a box."""
    rng = np.random.default_rng(1)
    return Mesh(rng.uniform(-0.03, 0.03, (900, 3)), np.arange(900).reshape(-1, 3))


def torus(rough=0.0, count=1000):
    """A torus of `count`² triangles, whose points are off by up to `rough` [m]."""
    around = count // 2
    i, j = np.meshgrid(np.arange(count), np.arange(around), indexing="ij")
    turn, tilt = 2 * np.pi * i / count, 2 * np.pi * j / around
    radius = 0.01 + rough * np.random.default_rng(1).uniform(-1, 1, i.shape)
    out = 0.03 + radius * np.cos(tilt)
    points = np.stack([out * np.cos(turn), out * np.sin(turn), radius * np.sin(tilt)], axis=-1)
    a, b = i * around + j, (i + 1) % count * around + j
    c, d = (i + 1) % count * around + (j + 1) % around, i * around + (j + 1) % around
    triangles = np.concatenate([np.stack(half, axis=-1).reshape(-1, 3) for half in ([a, b, c], [a, c, d])])
    return Mesh(points.reshape(-1, 3), triangles)


POINTS, FACES = RING
BALL, CORE = of(icosphere(2, 0.03)), of(icosphere(2, 0.02))
POISONED = {
    "not manifold": _not_manifold,
    "inverted": lambda: Mesh(POINTS, FACES[:, ::-1]),
    "half inverted": _half_inverted,
    "no volume": lambda: Mesh(POINTS * [1, 1, 0], FACES),
    "one triangle": lambda: Mesh(np.array([[0.0, 0, 0], [0.05, 0, 0], [0, 0.05, 0]]), np.array([[0, 1, 2]])),
    "NaN": _nan,
    "needle": lambda: of(box((0.1, 1e-9, 1e-9))),
    "two shells": lambda: together(RING, shifted(RING, 0.1, 0.0, 0.0)),
    "two overlapping": lambda: together(RING, shifted(RING, 0.03, 0.0, 0.0)),
    "hollow": lambda: together(BALL, (CORE[0], CORE[1][:, ::-1])),
    "doubled": lambda: Mesh(POINTS, np.concatenate([FACES, FACES])),
    "self-intersecting": _self_intersecting,
    "tangle": _tangle,
    "open": lambda: Mesh(POINTS, FACES[len(FACES) // 3 :]),
    "empty": lambda: Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)),
    "large": lambda: of(icosphere(2, 1000.0)),
    "far": lambda: shifted(RING, 1e4, 0.0, 0.0),
}
