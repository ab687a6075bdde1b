"""Robots in MJCF that have everything the page shows, and a reading of their packs that knows no MuJoCo."""

import struct

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float64]

HOSTILE = '</script><img src=x onerror="alert(1)">'

INCLUDED = """<mujoco model="part">
  <compiler angle="radian" meshdir="assets" autolimits="true"/>
  <option timestep="0.001" integrator="implicitfast"/>
  <default>
    <default class="seen"><geom group="2" contype="0" conaffinity="0" density="0"/></default>
    <default class="hit"><geom group="3" density="0"/></default>
  </default>
  <asset>
    <texture name="red" type="2d" builtin="flat" rgb1="0.8 0.2 0.2" width="8" height="8"/>
    <material name="painted" texture="red" rgba="0.5 1 1 1"/>
    <material name="plain" rgba="0.1 0.2 0.3 1"/>
    <mesh name="shell" file="shell.stl"/><mesh file="hull.stl" scale="0.5 0.5 0.5"/>
  </asset>
  <worldbody>
    <body name="base" pos="0 0 1">
      <freejoint/>
      <inertial pos="0.01 0 0" mass="3" diaginertia="0.03 0.03 0.02"/>
      <geom class="seen" type="mesh" mesh="shell" material="painted"/>
      <geom class="hit" type="mesh" mesh="hull"/>
      <site name="imu" pos="0.1 0 0" quat="0.6 0.8 0 0"/>
      <body name="arm" pos="0.3 0 0.1" quat="0.8 0 0.6 0">
        <joint name="slide" type="slide" axis="1 1 0" range="-0.1 0.2" ref="0.05"/>
        <joint name="turn" axis="0 1 0.5" pos="0.02 0 0.03" range="-1 2" ref="0.4"/>
        <geom class="seen" type="box" size="0.1 0.02 0.03" rgba="1 0 0 1"/>
        <geom name="heavy" type="capsule" size="0.02 0.1" density="700"/>
        <body name="ball" pos="0 0 0.3">
          <joint name="globe" type="ball" pos="0 0.01 0"/>
          <inertial pos="0 0 0" mass="0.2" fullinertia="0.002 0.003 0.004 0.0001 0 0"/>
          <geom class="hit" type="sphere" size="0.03"/>
          <site name="tip" pos="0 0 0.05"/>
        </body>
      </body>
      <body name="follower" pos="-0.3 0 0">
        <joint name="gear" axis="0 0 1" ref="0.2"/>
        <inertial pos="0 0 0.02" mass="0.3" diaginertia="0.001 0.001 0.001"/>
        <geom class="hit" type="cylinder" size="0.03 0.02"/>
        <body name="hand" pos="0 0.2 0"><joint name="wrist" axis="1 0 0"/><joint name="pass" axis="0 1 0"/>
          <geom type="ellipsoid" size="0.02 0.03 0.04" mass="0.1"/></body>
      </body>
    </body>
  </worldbody>
  <equality>
    <joint name="geared" joint1="gear" joint2="turn" polycoef="0 -2 0.5 0 0"/>
    <joint name="stuck" joint1="pass" polycoef="0.1"/>
    <joint name="off" joint1="wrist" joint2="turn" active="false"/>
  </equality>
  <actuator>
    <position name="drive" joint="turn" kp="20" kv="1" ctrlrange="-1 2"/>
    <motor name="push" joint="slide" gear="2"/>
    <velocity name="spin" joint="gear" kv="0.1"/>
    <general name="lift" joint="wrist" gainprm="3" ctrlrange="-1 1"/>
  </actuator>
  <sensor><jointpos name="angle" joint="turn"/></sensor>
  <keyframe>
    <key name="first" qpos="0 0 1 1 0 0 0  0.1 0.5 1 0 0 0 0.2 0 0.1" ctrl="0.1 0 0 0"/>
    <key name="home" qpos="0 0 1.2 1 0 0 0  0.05 0.4 0.6 0.8 0 0 0.2 0 0.1" ctrl="0.4 0 0 0"/>
  </keyframe>
</mujoco>"""

SCENE = """<mujoco model="scene">
  <include file="robot.xml"/>
  <statistic center="0 0 1" extent="0.8"/>
  <visual><global azimuth="150" elevation="-25"/></visual>
  <asset><texture name="tiles" type="2d" builtin="checker" rgb1="1 1 1" rgb2="0 0 0" width="8" height="8"/>
    <material name="tiles" texture="tiles"/></asset>
  <worldbody><geom name="floor" type="plane" size="2 2 0.1" material="tiles"/><light pos="0 0 2"/>
    <camera name="overview" pos="1 0 1"/></worldbody>
</mujoco>"""

LINKAGE = """<mujoco model="linkage">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="left"><joint name="a" axis="0 0 1"/><geom size="0.02" contype="0" conaffinity="0"/>
      <body name="bar" pos="0 0.3 0"><joint name="b" axis="0 0 1"/>
        <geom type="capsule" size="0.01" fromto="0 0 0 0.5 0 0" contype="0" conaffinity="0"/>
        <site name="bar_end" pos="0.5 0 0" quat="0.8 0 0 0.6"/></body></body>
    <body name="right" pos="0.5 0 0"><joint name="c" axis="0 0 1"/>
      <geom size="0.02" contype="0" conaffinity="0"/>
      <site name="right_end" pos="0 0.3 0" quat="0.8 0 0 0.6"/></body>
    <body name="copy" pos="0 0 0.4"><freejoint/><geom size="0.02"/></body>
  </worldbody>
  <equality>{loop}<weld name="carried" body1="left" body2="copy"/></equality>
</mujoco>"""
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
    placed: list[tuple[Vector, Vector]] = []
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


def triangles(header, content, mesh):
    """The corners (m, 3, 3) of a mesh of the pack."""
    entry = header["meshes"][mesh]
    place = entry["positions"]
    steps = np.frombuffer(content, "<u2", 3 * place["count"], place["at"]).reshape(-1, 3)
    points = np.array(place["origin"]) + np.array(place["step"]) * steps
    kind = {2: "<u2", 4: "<u4"}[entry["indices"]["bytes"]]
    corners = np.frombuffer(content, kind, entry["indices"]["count"], entry["indices"]["at"])
    return np.asarray(points[corners.reshape(-1, 3)])
