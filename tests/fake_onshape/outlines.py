"""Closed outlines in the plane (n, 2), anticlockwise, and their triangulation. Lengths in metres."""

import numpy as np

TURN = 2 * np.pi


def circle(radius, at=(0.0, 0.0), segments=32):
    """A regular polygon inscribed in the circle."""
    angles = TURN * np.arange(segments) / segments
    return np.asarray(at, float) + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def rounded_rectangle(width, height, radius, at=(0.0, 0.0), segments=8):
    """A rectangle with rounded corners; `segments` edges a corner."""
    corners = []
    for index, (sx, sy) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        angles = TURN / 4 * (index + np.arange(segments + 1) / segments)
        centre = np.array([sx * (width / 2 - radius), sy * (height / 2 - radius)])
        corners.append(centre + radius * np.column_stack([np.cos(angles), np.sin(angles)]))
    return np.asarray(at, float) + np.concatenate(corners)


def hull(*outlines):
    """The convex hull of the outlines' points (monotone chain)."""
    points = sorted({(float(x), float(y)) for outline in outlines for x, y in outline})

    def chain(ordered):
        kept = []
        for point in ordered:
            while len(kept) > 1 and _cross(kept[-2], kept[-1], point) <= 1e-15:
                kept.pop()
            kept.append(point)
        return kept[:-1]

    return np.array(chain(points) + chain(points[::-1]))


def stroke(points, radius, segments=10):
    """A line of even width along `points`, with round ends and round outer bends."""
    points = np.asarray(points, float)
    return np.concatenate([_side(points, radius, segments), _side(points[::-1], radius, segments)])


def _side(points, radius, segments):
    """The right-hand side of a stroke, with the round cap at its end."""
    steps = np.diff(points, axis=0)
    steps /= np.linalg.norm(steps, axis=1)[:, None]
    headings = np.arctan2(steps[:, 1], steps[:, 0])
    side = [points[0] + radius * np.array([steps[0, 1], -steps[0, 0]])]
    for index, at in enumerate(points[1:-1], start=1):
        turn = (headings[index] - headings[index - 1] + np.pi) % TURN - np.pi
        if turn > 0:
            count = max(1, int(np.ceil(segments * turn / np.pi)))
            angles = headings[index - 1] - np.pi / 2 + turn * np.arange(count + 1) / count
            side.extend(at + radius * np.column_stack([np.cos(angles), np.sin(angles)]))
        else:
            middle = headings[index - 1] - np.pi / 2 + turn / 2
            side.append(at + radius / np.cos(turn / 2) * np.array([np.cos(middle), np.sin(middle)]))
    angles = headings[-1] - np.pi / 2 + np.pi * np.arange(segments) / segments
    side.extend(points[-1] + radius * np.column_stack([np.cos(angles), np.sin(angles)]))
    return np.array(side)


def gear(teeth, pitch_radius, phase=0.0):
    """A wheel with trapezoid teeth; `phase` turns it by a part of one tooth."""
    module = 2 * pitch_radius / teeth
    radii = np.tile([pitch_radius - module, pitch_radius - module, pitch_radius + 0.9 * module] * 2, teeth)
    radii = radii.reshape(teeth, 6)[:, [0, 2, 2, 0]].ravel()
    within = np.array([0.12, 0.36, 0.64, 0.88]) + phase
    angles = TURN / teeth * (np.arange(teeth)[:, None] + within).ravel()
    return radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


def inset(outline, distance):
    """The outline with every edge moved inwards by `distance` (small against its features)."""
    outline = np.asarray(outline, float)
    edges = np.roll(outline, -1, axis=0) - outline
    edges /= np.linalg.norm(edges, axis=1)[:, None]
    normals = np.column_stack([-edges[:, 1], edges[:, 0]])
    before = np.roll(normals, 1, axis=0)
    return outline + distance * (normals + before) / (1 + np.sum(normals * before, axis=1))[:, None]


def area(outline):
    """The signed area [m²], positive anticlockwise."""
    outline = np.asarray(outline, float)
    x, y = outline.T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2


def triangulate(outline, holes=()):
    """Triangles (k, 3) over the points of `outline` and then of `holes`, anticlockwise.

    Every edge of every outline is an edge of one triangle, so caps and walls share their edges.
    """
    points = np.concatenate([np.asarray(ring, float) for ring in (outline, *holes)])
    ring, first = list(range(len(outline))), len(outline)
    waiting = []
    for hole in holes:
        waiting.append(list(range(first, first + len(hole)))[::-1])
        first += len(hole)
    for hole in sorted(waiting, key=lambda indices: -max(points[indices][:, 0])):
        obstacles = [ring, *[other for other in waiting if other is not hole], hole]
        at, via = _bridge(points, ring, hole, obstacles)
        ring = ring[: at + 1] + hole[via:] + hole[: via + 1] + ring[at:]
    return _clip_ears(points, ring)


def _cross(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _bridge(points, ring, hole, rings):
    """Positions in `ring` and `hole` of the shortest cut between them that crosses nothing."""
    gaps = np.linalg.norm(points[ring][:, None] - points[hole][None], axis=2)
    for flat in np.argsort(gaps, axis=None, kind="stable"):
        at, via = divmod(int(flat), len(hole))
        a, b = points[ring[at]], points[hole[via]]
        if not any(_crosses(points, a, b, other) for other in rings):
            return at, via
    msg = "a hole cannot be joined to its outline: it lies outside, or the outline crosses itself"
    raise ValueError(msg)


def _crosses(points, a, b, ring):
    start, end = points[ring], points[np.roll(ring, -1)]

    def sides(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (
            r[..., 0] - p[..., 0]
        )

    across_first = sides(a, b, start) * sides(a, b, end) < -1e-24
    across_second = sides(start, end, a) * sides(start, end, b) < -1e-24
    return bool(np.any(across_first & across_second))


def _clip_ears(points, ring):
    ring, triangles = list(ring), []
    while len(ring) > 3:
        place = next((i for i in range(len(ring)) if _is_ear(points, ring, i)), None)
        if place is None:
            msg = "the outline crosses itself: no ear is left to cut"
            raise ValueError(msg)
        triangles.append([ring[place - 1], ring[place], ring[(place + 1) % len(ring)]])
        del ring[place]
        # Starting behind the last cut keeps fans, and so slivers, short.
        ring = ring[place:] + ring[:place]
    return np.array([*triangles, ring])


def _is_ear(points, ring, place):
    a, b, c = (points[ring[k]] for k in (place - 1, place, (place + 1) % len(ring)))
    if _cross(a, b, c) <= 1e-16:
        return False
    ring_points = points[ring]
    same = np.zeros(len(ring), bool)
    for corner in (a, b, c):
        same |= np.all(ring_points == corner, axis=1)
    inside = np.ones(len(ring), bool)
    for start, end in ((a, b), (b, c), (c, a)):
        edge = end - start
        inside &= (
            edge[0] * (ring_points[:, 1] - start[1]) - edge[1] * (ring_points[:, 0] - start[0]) >= -1e-16
        )
    return not np.any(inside & ~same)
