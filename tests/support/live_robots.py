"""Robots in MJCF that have everything the page shows, and a reading of their packs that knows no MuJoCo."""

import struct

import numpy as np

from tests.support.places import MODELS

HOSTILE = '</script><img src=x onerror="alert(1)">'

INCLUDED = (MODELS / "live_robot.xml").read_text()

SCENE = (MODELS / "live_scene.xml").read_text()

LINKAGE = (MODELS / "linkage.xml").read_text()
"""A parallelogram that one of `LOOPS` closes, and a body that a weld carries."""

LOOPS = {
    "bodies": '<connect name="loop" body1="bar" body2="right" anchor="0.5 0 0"/>',
    "sites": '<connect name="loop" site1="bar_end" site2="right_end"/>',
    "weld of sites": '<weld name="loop" site1="bar_end" site2="right_end"/>',
}


def stl(corners):
    """A binary STL of triangles (m, 3, 3)."""
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    faces = np.zeros(len(corners), dtype=kind)
    faces["corners"] = corners
    return bytes(80) + struct.pack("<I", len(corners)) + faces.tobytes()


def bumpy(subdivisions=2, size=0.1, seed=0):
    """A closed surface that is no sphere, (m, 3, 3)."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    wave = np.sin(ball.vertices @ np.random.default_rng(seed).normal(size=(3, 3)) * 3).sum(axis=1)
    points = ball.vertices * (1 + 0.1 * wave)[:, None] * [size, 0.7 * size, 0.5 * size]
    return np.asarray(points[ball.faces])


def write(folder, scene=SCENE, robot=INCLUDED):
    """The files of a build: a scene, the robot that it includes, and its meshes."""
    (folder / "assets").mkdir(parents=True, exist_ok=True)
    (folder / "scene.xml").write_text(scene, encoding="utf-8")
    (folder / "robot.xml").write_text(robot, encoding="utf-8")
    (folder / "assets" / "shell.stl").write_bytes(stl(bumpy()))
    (folder / "assets" / "hull.stl").write_bytes(stl(bumpy(1, 0.2, 1)))
    return folder


def times(a, b):
    """The product of two quaternions, w first."""
    w, v, x, u = a[0], a[1:], b[0], b[1:]
    return np.array([w * x - v @ u, *(w * u + x * v + np.cross(v, u))])


def turned(q, v):
    """A vector turned by a unit quaternion."""
    return np.asarray(v + 2 * np.cross(q[1:], np.cross(q[1:], v) + q[0] * v))


def poses(header, qpos):
    """Position and quaternion of each body in the world, by the header alone."""
    placed = []
    for index, body in enumerate(header["bodies"]):
        if index == 0:
            placed.append((np.zeros(3), np.array([1.0, 0, 0, 0])))
            continue
        above, frame = placed[body["parent"]]
        place, turn = above + turned(frame, np.array(body["pos"])), times(frame, np.array(body["quat"]))
        for joint in (entry for entry in header["joints"] if entry["body"] == index):
            at = joint["qpos"]
            if joint["type"] == "free":
                place, turn = qpos[at : at + 3], qpos[at + 3 : at + 7] / np.linalg.norm(qpos[at + 3 : at + 7])
                continue
            anchor = place + turned(turn, np.array(joint["pos"]))
            axis = np.array(joint["axis"])
            value = qpos[at] - joint["ref"]
            if joint["type"] == "slide":
                place = place + turned(turn, axis) * value
                continue
            way = np.array([np.cos(value / 2), *(np.sin(value / 2) * axis)])
            if joint["type"] == "ball":
                way = qpos[at : at + 4] / np.linalg.norm(qpos[at : at + 4])
            turn = times(turn, way)
            place = anchor - turned(turn, np.array(joint["pos"]))
        placed.append((place, turn / np.linalg.norm(turn)))
    return placed


def frames_of(header, qpos, loop):
    """The places (3,) and orientations (4,) of the two frames of a loop in the world."""
    where = poses(header, qpos)
    for body, frame in zip(loop["bodies"], (loop["a_from"], loop["b_from"]), strict=True):
        place, turn = where[body]
        yield place + turned(turn, np.array(frame["pos"])), times(turn, np.array(frame["quat"]))


def triangles(header, content, mesh):
    """The corners (m, 3, 3) of a mesh of the pack."""
    entry = header["meshes"][mesh]
    place = entry["positions"]
    steps = np.frombuffer(content, "<u2", 3 * place["count"], place["at"]).reshape(-1, 3)
    points = np.array(place["origin"]) + np.array(place["step"]) * steps
    kind = {2: "<u2", 4: "<u4"}[entry["indices"]["bytes"]]
    corners = np.frombuffer(content, kind, entry["indices"]["count"], entry["indices"]["at"])
    return np.asarray(points[corners.reshape(-1, 3)])
