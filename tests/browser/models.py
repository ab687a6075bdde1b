"""Small models for the view, and the sample as a build leaves it."""

import re
from functools import cache

import mujoco
import numpy as np

from tests.browser.packs import pack_of, packed

ALL_JOINTS = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.002"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 .1"/>
    <body name="base" pos="0 0 1.2">
      <freejoint name="base"/>
      <geom name="torso" type="box" size=".2 .15 .1" mass="2"/>
      <body name="upper" pos=".2 0 .05" quat=".9 .1 .3 .2">
        <joint name="shoulder" type="ball" pos=".01 .02 -.03" range="0 1.2"/>
        <geom type="capsule" size=".04 .1" mass=".5"/>
        <body name="rail" pos=".1 .2 0" quat=".7 0 .7 .1">
          <joint name="slide" type="slide" axis="1 .5 0" range="-.1 .3" ref=".07"/>
          <joint name="turn" type="hinge" axis="0 1 .3" pos=".02 0 .05" range="-1 2" ref=".4"/>
          <geom type="cylinder" size=".03 .08" mass=".3"/>
          <body name="tip" pos="0 0 .2">
            <joint name="wrist" type="hinge" axis="1 0 0"/>
            <geom type="ellipsoid" size=".05 .03 .08" mass=".2"/>
            <site name="tool" pos="0 0 .1"/>
          </body>
        </body>
      </body>
    </body>
    <body name="post" pos="1 0 .5" quat=".8 0 .6 0"><geom type="sphere" size=".1" mass="1"/></body>
  </worldbody>
</mujoco>
"""

FOUR_BAR = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.001"/>
  <worldbody>
    <body name="crank" pos="0 0 1">
      <joint name="crank" axis="0 1 0" range="-3 3"/>
      <geom type="capsule" fromto="0 0 0 0 0 .2" size=".02" mass=".1"/>
      <body name="coupler" pos="0 0 .2">
        <joint name="elbow" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 .5 0 .1" size=".02" mass=".1"/>
        <site name="end" pos=".5 0 .1"/>
      </body>
    </body>
    <body name="rocker" pos=".5 0 1">
      <joint name="rocker" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 .3" size=".02" mass=".1"/>
      <site name="top" pos="0 0 .3"/>
      <body name="gear" pos="0 .1 0">
        <joint name="gear" axis="0 1 0" ref=".2"/>
        <geom type="sphere" size=".04" mass=".1"/>
      </body>
    </body>
  </worldbody>
  <equality>
    <connect site1="end" site2="top"/>
    <joint joint1="gear" joint2="rocker" polycoef=".1 -2 .3 0 0"/>
  </equality>
</mujoco>
"""

SLIDER_CRANK = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="crank" pos="0 0 1">
      <joint name="crank" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 .2" size=".02" mass=".1"/>
      <body name="rod" pos="0 0 .2">
        <joint name="rod" type="ball"/>
        <geom type="capsule" fromto="0 0 0 .5 0 0" size=".02" mass=".1"/>
        <site name="end" pos=".5 0 0" quat=".6 0 .8 0"/>
      </body>
    </body>
    <body name="slider" pos=".5 0 1.2">
      <joint name="slide" type="slide" axis="1 0 0"/>
      <joint name="pin" type="ball"/>
      <geom type="box" size=".05 .03 .03" mass=".1"/>
      <site name="pin" quat=".6 0 .8 0"/>
    </body>
  </worldbody>
  <equality><weld site1="end" site2="pin"/></equality>
</mujoco>
"""


@cache
def model_of(xml):
    return mujoco.MjModel.from_xml_string(xml)


@cache
def small_pack(xml):
    """With the engine's own copy, the same text."""
    return packed(pack_of(model_of(xml), xml))


def chain(links):
    """A chain of links side by side, each with a box and a collider."""
    body = '<geom type="box" size=".02 .02 .04" group="2" contype="0" conaffinity="0" mass=".01"/>'
    body += '<geom type="capsule" size=".015 .03" group="3" mass=".01"/>'
    text = ""
    for index in reversed(range(links)):
        joint = (
            f'<joint name="joint_{index}" axis="0 {index % 2} {1 - index % 2}" range="-.5 .5" damping="1"/>'
        )
        text = f'<body name="link_{index}" pos="0 0 .1">{joint}{body}{text}</body>'
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody>{text}</worldbody></mujoco>'
    )


def renamed(xml, name):
    """With a name of a user's making in the place of the first body's."""
    escaped = name.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    return re.sub(r'body name="\w+"', lambda _: f'body name="{escaped}"', xml, count=1)


HELD = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 .1"/>
    <body name="block" pos=".4 0 .05">
      <freejoint/>
      <geom type="box" size=".05 .05 .05" mass=".2" group="2"/>
    </body>
    <body name="post" pos="0 0 .02">
      <geom type="cylinder" fromto="0 0 0 0 0 .3" size=".05" mass="2" contype="0" conaffinity="0"/>
      <body name="arm" pos="0 0 .3">
        <joint name="shoulder" axis="0 1 0" range="-1 1" damping=".2" armature=".01"/>
        <geom type="box" pos="0 0 .15" size=".04 .04 .15" mass=".5" group="2" contype="0" conaffinity="0"/>
        <body name="forearm" pos="0 0 .3">
          <joint name="elbow" axis="0 1 0" range="-2 2" damping=".2" armature=".01"/>
          <geom type="box" pos="0 0 .1" size=".05 .05 .1" mass=".3" group="2" contype="0" conaffinity="0"/>
          <geom type="capsule" fromto="0 0 0 0 0 .2" size=".04" mass="0" group="3"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="shoulder" joint="shoulder" kp="200" kv="10" ctrlrange="-1 1"/>
    <position name="elbow" joint="elbow" kp="200" kv="10" ctrlrange="-2 2"/>
  </actuator>
  <keyframe>
    <key name="home" qpos=".4 0 .0499 1 0 0 0 .2 .4" ctrl=".2 .4"/>
    <key name="up" qpos=".4 0 .0499 1 0 0 0 0 0" ctrl="0 0"/>
  </keyframe>
</mujoco>
"""
"""An arm that holds itself, beside a block that lies on the ground."""

CARRIED = (
    HELD.replace("<position", "<intvelocity")
    .replace("ctrlrange", "actrange")
    .replace('ctrl=".2 .4"', 'act=".2 .4"')
    .replace('ctrl="0 0"', "")
)
"""The same, by actuators whose control is the speed of a target, which is a state."""


def sphere(triangles):
    """A ball of one mesh with about so many triangles."""
    rows = round((triangles / 4) ** 0.5)
    turns, rises = np.linspace(0, 2 * np.pi, 2 * rows, endpoint=False), np.linspace(0, np.pi, rows + 1)[1:-1]
    turn, rise = (axis.ravel() for axis in np.meshgrid(turns, rises))
    points = 0.3 * np.stack([np.sin(rise) * np.cos(turn), np.sin(rise) * np.sin(turn), np.cos(rise)], axis=1)
    points = np.concatenate([points, [[0, 0, 0.3], [0, 0, -0.3]]])
    ring, at = 2 * rows, np.arange(2 * rows)
    faces = [np.stack([np.full(ring, ring * (rows - 1)), at, (at + 1) % ring], axis=1)]
    for row in range(rows - 2):
        a, b = row * ring + at, row * ring + (at + 1) % ring
        faces += [np.stack([a, a + ring, b], axis=1), np.stack([b, a + ring, b + ring], axis=1)]
    last = ring * (rows - 2)
    faces += [np.stack([np.full(ring, ring * (rows - 1) + 1), last + (at + 1) % ring, last + at], axis=1)]
    vertex = " ".join(f"{value:.6f}" for value in points.ravel())
    face = " ".join(map(str, np.concatenate(faces).ravel()))
    return (
        f'<mujoco><asset><mesh name="ball" vertex="{vertex}" face="{face}"/></asset><worldbody>'
        '<body name="ball" pos="0 0 .3"><joint name="turn"/>'
        '<geom type="mesh" mesh="ball" group="2" contype="0" conaffinity="0" mass="1"/></body>'
        "</worldbody></mujoco>"
    )
