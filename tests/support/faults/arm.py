"""An arm of three links as a URDF and an MJCF that come alone, in which faults of bare files are planted."""

import struct
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from linkwright.stages.robot.check import Check


def box_stl(x: float, y: float, z: float) -> bytes:
    """A box around its origin, of these lengths, as a binary STL."""
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * (x / 2, y / 2, z / 2)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [(a, b, c) for a, b, c, _ in sides] + [(a, c, d) for a, _, c, d in sides]
    rows = [struct.pack("<12fH", 0, 0, 0, *corners[list(face)].ravel(), 0) for face in faces]
    return b"\0" * 80 + struct.pack("<I", len(rows)) + b"".join(rows)


LINK = """<link name="{name}">
  <inertial><origin xyz="0 0 0.1"/><mass value="1"/>
    <inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0009"/></inertial>
  <visual><origin xyz="0 0 0.1"/><geometry><mesh filename="{name}.stl"/></geometry></visual>
  <collision><origin xyz="0 0 0.1"/><geometry><box size="0.07 0.07 0.2"/></geometry></collision>
</link>
"""

JOINT = """<joint name="{name}" type="revolute">
  <origin xyz="0 0 0.25"/><parent link="{parent}"/><child link="{child}"/><axis xyz="0 1 0"/>
  <limit lower="-1.5" upper="1.5" effort="10" velocity="3"/><dynamics damping="0.1" friction="0.01"/>
</joint>
"""

URDF = (
    '<robot name="arm">\n'
    + "".join(LINK.format(name=name) for name in ("base", "upper", "lower"))
    + JOINT.format(name="shoulder", parent="base", child="upper")
    + JOINT.format(name="elbow", parent="upper", child="lower").replace(
        "</joint>", '  <mimic joint="shoulder" multiplier="1"/>\n</joint>'
    )
    + "</robot>\n"
)

MJCF = """<mujoco model="arm">
  <compiler angle="radian"/>
  <asset><mesh file="base.stl"/><mesh file="upper.stl"/><mesh file="lower.stl"/></asset>
  <default>
    <joint damping="0.1" frictionloss="0.01" armature="0.01"/>
    <default class="visual"><geom type="mesh" contype="0" conaffinity="0" density="0" group="2"/></default>
    <default class="collision"><geom type="box" size="0.035 0.035 0.1" density="0"/></default>
  </default>
  <worldbody>
    <body name="base">
      <inertial pos="0 0 0.1" mass="1" diaginertia="0.004 0.004 0.0009"/>
      <geom class="visual" mesh="base" pos="0 0 0.1"/><geom class="collision" pos="0 0 0.1"/>
      <body name="upper" pos="0 0 0.25" quat="1 0 0 0">
        <joint name="shoulder" axis="0 1 0" range="-1.5 1.5"/>
        <inertial pos="0 0 0.1" mass="1" diaginertia="0.004 0.004 0.0009"/>
        <geom class="visual" mesh="upper" pos="0 0 0.1"/>
        <geom name="upper" class="collision" pos="0 0 0.1"/>
        <site name="upper_end" pos="0 0 0.25"/>
        <body name="lower" pos="0 0 0.25">
          <joint name="elbow" axis="0 1 0" range="-1.5 1.5"/>
          <inertial pos="0 0 0.1" mass="1" diaginertia="0.004 0.004 0.0009"/>
          <geom class="visual" mesh="lower" pos="0 0 0.1"/><geom class="collision" pos="0 0 0.1"/>
          <site name="lower_start"/>
        </body>
      </body>
    </body>
    <body name="ball" pos="0 1 0.3">
      <freejoint name="ball"/><geom name="ball" size="0.05" mass="0.5"/>
    </body>
  </worldbody>
  <equality>
    <joint joint1="elbow" joint2="shoulder" polycoef="0 1 0 0 0"/>
    <connect name="loop" site1="upper_end" site2="lower_start"/>
  </equality>
  <actuator><position name="shoulder" joint="shoulder" kp="20" ctrlrange="-1.5 1.5"/></actuator>
  <keyframe><key name="home" qpos="0.1 0.1 0 1 0.3 1 0 0 0" ctrl="0.1"/></keyframe>
</mujoco>
"""


def write_arm(folder: Path) -> Path:
    """Writes both files and their meshes."""
    for name in ("base", "upper", "lower"):
        (folder / f"{name}.stl").write_bytes(box_stl(0.07, 0.07, 0.2))
    (folder / "arm.urdf").write_text(URDF)
    (folder / "arm.xml").write_text(MJCF)
    return folder


def replace_last(path: Path, old: str, new: str) -> None:
    """Replaces the last place of a text in a file: that of the last link or joint."""
    before, middle, after = path.read_text().rpartition(old)
    assert middle, old
    path.write_text(before + new + after)


def problems(checks: Iterable[Check]) -> set[tuple[str, str, str]]:
    """Code, element and attribute of the findings of checks that do not pass."""
    return {
        (check.code, finding.element, finding.attribute)
        for check in checks
        if not check.passed
        for finding in check.findings
    }
