"""Trots open-loop for ten seconds: `python trot.py outputs/quadruped/scene.xml`."""

import math
import sys

import mujoco

LENGTH = 0.13  # of a thigh and of a shank, from axis to axis [m]
HEIGHT = 0.21  # of the hips' axes above the middles of the feet [m]
PERIOD, STRIDE, LIFT = 0.4, 0.08, 0.05  # of a step [s, m, m]
DIAGONALS = {"front_left": 0.0, "rear_right": 0.0, "front_right": 0.5, "rear_left": 0.5}


def foot(phase):
    """Where a foot is ahead of its hip, and above the ground [m]: half a period it pushes, then it swings."""
    if phase < 0.5:
        return STRIDE * (0.5 - 2 * phase), 0.0
    swing = 2 * phase - 1
    return -STRIDE / 2 * math.cos(math.pi * swing), LIFT * math.sin(math.pi * swing)


def angles(x, z):
    """The angles of the hip and the knee that put the foot at (x, z) from the hip [rad]."""
    knee = -2 * math.acos(math.hypot(x, z) / (2 * LENGTH))
    return math.atan2(-x, -z) - knee / 2, knee


model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
while data.time < 10:
    ramp = min(1.0, data.time)  # the first steps are smaller
    for leg, start in DIAGONALS.items():
        ahead, above = foot((data.time / PERIOD + start) % 1.0)
        hip, knee = angles(ramp * ahead, ramp * above - HEIGHT)
        data.actuator(f"{leg}_hip").ctrl = hip
        data.actuator(f"{leg}_knee").ctrl = knee
    mujoco.mj_step(model, data)
x, y, z = data.qpos[:3]
print(f"{x:.2f} m ahead, {y:.2f} m to the left")
