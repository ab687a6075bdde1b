"""Closed polyhedra: what the local server serves, and their exact mass properties.

A solid's properties are integrals over its own triangles, so "CAD" and the served mesh agree
exactly. Vertices are kept on a grid of 0.1 µm, which keeps replies short and exact in text.
"""

from dataclasses import dataclass
from functools import cached_property
from math import fsum

import numpy as np

from tests.fake_onshape import outlines


@dataclass(frozen=True, eq=False)
class Face:
    """A named face: triangles (k, 3) over the solid's vertices, anticlockwise from outside."""

    name: str
    triangles: np.ndarray


@dataclass(frozen=True, eq=False)
class Properties:
    """Volume [m³], surface [m²], centroid [m] (3,), and the volume's second moments about the
    centroid as an inertia tensor of density 1 [m⁵] (3, 3), with true signs."""

    volume: float
    area: float
    centroid: np.ndarray
    inertia: np.ndarray


@dataclass(frozen=True, eq=False)
class Solid:
    """One or more closed shells; vertices (V, 3) in metres."""

    vertices: np.ndarray
    faces: tuple[Face, ...]

    @classmethod
    def of(cls, vertices, faces):
        """A solid from vertices and `{name: triangles}`."""
        kept = tuple(
            Face(name, np.asarray(triangles, int).reshape(-1, 3)) for name, triangles in faces.items()
        )
        grid = np.round(np.asarray(vertices, float), 7) + 0.0
        return cls(grid, kept)

    @property
    def triangles(self):
        return np.concatenate([face.triangles for face in self.faces])

    def moved(self, frame):
        """The solid moved by a (4, 4) rigid transform."""
        vertices = self.vertices @ frame[:3, :3].T + frame[:3, 3]
        return Solid.of(vertices, {face.name: face.triangles for face in self.faces})

    def reflected(self, reflection):
        """The mirror image by a (4, 4) reflection, off the grid, so that it is exact."""
        vertices = self.vertices @ reflection[:3, :3].T + reflection[:3, 3]
        return Solid(vertices, tuple(Face(face.name, face.triangles[:, ::-1]) for face in self.faces))

    def named(self, prefix):
        """The solid with `prefix` before the names of its faces."""
        return Solid(self.vertices, tuple(Face(f"{prefix} {f.name}", f.triangles) for f in self.faces))

    def painted(self, colour, *words):
        """{name: colour} of the faces whose names have one of `words` in them; without words, of all."""
        names = [face.name for face in self.faces]
        return {name: colour for name in names if not words or any(word in name for word in words)}

    def __add__(self, other):
        """Both solids as the shells of one part. Shells may touch; overlaps count twice."""
        names = {face.name for face in self.faces}
        faces = {face.name: face.triangles for face in self.faces}
        for face in other.faces:
            name = face.name
            while name in names:
                name += "'"
            names.add(name)
            faces[name] = face.triangles + len(self.vertices)
        return Solid.of(np.concatenate([self.vertices, other.vertices]), faces)

    @cached_property
    def properties(self):
        """Exact integrals over the polyhedron, by signed tetrahedra from a point amid it.

        Sums are `math.fsum`'s: correctly rounded, so the same on every processor.
        """
        middle = (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2
        a, b, c = (self.vertices - middle)[self.triangles].transpose(1, 2, 0)
        x, y, z = _cross(b, c)
        signed = (a[0] * x + a[1] * y + a[2] * z) / 6
        x, y, z = _cross(b - a, c - a)
        volume, area = fsum(signed), fsum(np.sqrt(x * x + y * y + z * z)) / 2
        total = a + b + c
        centre = np.array([fsum(signed * total[i]) for i in range(3)]) / (4 * volume)
        second = np.empty((3, 3))
        for i in range(3):
            for j in range(i + 1):
                terms = a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + total[i] * total[j]
                second[i, j] = fsum(signed * terms) / 20 - volume * centre[i] * centre[j]
                second[j, i] = second[i, j]
        trace = second[0, 0] + second[1, 1] + second[2, 2]
        return Properties(volume, area, centre + middle, trace * np.eye(3) - second)


def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def box(x, y, z, at=(0.0, 0.0, 0.0)):
    """A box with edges x, y, z [m] centred at `at`; its faces are named "+x" to "-z"."""
    signs = np.array([[sx, sy, sz] for sx in (-1, 1) for sy in (-1, 1) for sz in (-1, 1)], float)
    quads = {"-x": (0, 1, 3, 2), "+x": (4, 6, 7, 5), "-y": (0, 4, 5, 1), "+y": (2, 3, 7, 6)}
    quads |= {"-z": (0, 2, 6, 4), "+z": (1, 5, 7, 3)}
    faces = {name: [(a, b, c), (a, c, d)] for name, (a, b, c, d) in quads.items()}
    return Solid.of(np.asarray(at, float) + signs * np.array([x, y, z]) / 2, faces)


def extrude(outline, height, chamfer=0.0, holes=()):
    """The outline drawn from z = 0 to z = `height`, with chamfered rims and straight holes.

    Faces: "bottom", "top", "side", "chamfer", "hole 0" ...
    """
    outline = np.asarray(outline, float)
    if outlines.area(outline) < 0:
        outline = outline[::-1]
    rims = [(outline, 0.0), (outline, height)]
    if chamfer:
        small = outlines.inset(outline, chamfer)
        rims = [(small, 0.0), (outline, chamfer), (outline, height - chamfer), (small, height)]
    n = len(outline)
    rings = [np.column_stack([ring, np.full(n, z)]) for ring, z in rims]
    walls = [_wall(np.arange(n) + n * k, np.arange(n) + n * (k + 1)) for k in range(len(rims) - 1)]
    faces = {"side": walls[len(walls) // 2]}
    if chamfer:
        faces["chamfer"] = np.concatenate([walls[0], walls[2]])
    bottom, top = [np.arange(n)], [np.arange(n) + n * (len(rims) - 1)]
    count = n * len(rims)
    for index, hole in enumerate(holes):
        hole = np.asarray(hole, float)
        if outlines.area(hole) < 0:
            hole = hole[::-1]
        low = np.arange(len(hole)) + count
        high = low + len(hole)
        rings += [np.column_stack([hole, np.full(len(hole), z)]) for z in (0.0, height)]
        faces[f"hole {index}"] = _wall(low, high)[:, ::-1]
        bottom.append(low)
        top.append(high)
        count += 2 * len(hole)
    rings_of_holes = [hole if outlines.area(hole) > 0 else hole[::-1] for hole in holes]
    cap = outlines.triangulate(rims[0][0], rings_of_holes)
    faces["bottom"] = np.concatenate(bottom)[cap][:, ::-1]
    faces["top"] = np.concatenate(top)[cap]
    return Solid.of(np.concatenate(rings), faces)


def _wall(low, high):
    """Two triangles an edge between rings of indices, outward for an anticlockwise ring."""
    low_next, high_next = np.roll(low, -1), np.roll(high, -1)
    return np.concatenate(
        [np.column_stack([low, low_next, high_next]), np.column_stack([low, high_next, high])]
    )


def revolve(profile, segments=32):
    """A closed profile of (radius, z) points, anticlockwise in the (r, z) plane, turned about z.

    Each edge of the profile is a face, "face 0" from the first point on. Points on the axis have
    radius 0.
    """
    profile = np.asarray(profile, float)
    if outlines.area(profile) < 0:
        profile = profile[::-1]
    rings, vertices, count = [], [], 0
    angles = outlines.TURN * np.arange(segments) / segments
    for radius, z in profile:
        size = segments if radius > 0 else 1
        turned = radius * np.column_stack([np.cos(angles), np.sin(angles)])[:size]
        vertices.append(np.column_stack([turned, np.full(size, z)]))
        rings.append(count + np.arange(size))
        count += size
    faces = {}
    for index, ring in enumerate(rings):
        following = rings[(index + 1) % len(rings)]
        if len(ring) == len(following) == 1:
            continue
        low, high = np.broadcast_to(ring, segments), np.broadcast_to(following, segments)
        triangles = _wall(low, high)
        different = np.array([len(set(map(int, triangle))) == 3 for triangle in triangles])
        faces[f"face {index}"] = triangles[different]
    return Solid.of(np.concatenate(vertices), faces)


def cylinder(radius, height, chamfer=0.0, segments=32):
    """A cylinder about z from z = 0; an n-gon prism with chamfered rims."""
    c = chamfer
    if c:
        rim = [(0, 0), (radius - c, 0), (radius, c), (radius, height - c), (radius - c, height), (0, height)]
    else:
        rim = [(0, 0), (radius, 0), (radius, height), (0, height)]
    return revolve(rim, segments)


def tube(outer, inner, height, chamfer=0.0, segments=32):
    """A tube about z from z = 0, its outer rims chamfered."""
    c = chamfer
    rim = [(inner, 0), (outer - c, 0), (outer, c), (outer, height - c), (outer - c, height), (inner, height)]
    if not c:
        rim = [(inner, 0), (outer, 0), (outer, height), (inner, height)]
    return revolve(rim, segments)


def ball(radius, segments=24, rings=12):
    """A sphere about the origin, as a polyhedron inscribed in it."""
    angles = np.pi * np.arange(rings + 1) / rings - np.pi / 2
    profile = np.column_stack([radius * np.cos(angles), radius * np.sin(angles)])
    profile[[0, -1], 0] = 0.0
    return revolve(profile, segments)
