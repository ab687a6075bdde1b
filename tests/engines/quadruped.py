"""A quadruped: a trunk on four legs of three hinges each, drawn standing with bent knees, above the origin.

`quadruped_document().root` floats: no part is fixed. Closed forms for tests: `STANCE` is how far a foot's
lowest point is below the hips' axes.
"""

import math

from tests.fake_onshape import solids
from tests.fake_onshape.bundle import write_robot
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame, turn

ALUMINIUM, ABS, RUBBER = 2700.0, 1040.0, 1150.0  # kg/m³
GREY, BLUE, BLACK = (150, 154, 160), (46, 98, 168), (28, 29, 31)

THIGH, SHANK = 0.14, 0.14
FOOT = 0.018
"""The radius of a foot [m]."""

BEND = 0.6
"""How far the thighs lean back, and the shanks forward [rad]."""

STANCE = (THIGH + SHANK) * math.cos(BEND) + FOOT

LEGS = {"Front left": (1, 1), "Front right": (1, -1), "Rear left": (-1, 1), "Rear right": (-1, -1)}
"""Where each leg is: ahead (1) or behind, left (1) or right."""


def pitch(x=0.0, y=0.0, z=0.0):
    """A mate connector whose z is across the robot (+y): a positive turn moves what hangs down backwards."""
    return frame((x, y, z), x=(1, 0, 0), z=(0, 1, 0))


def roll(x=0.0, y=0.0, z=0.0):
    """A mate connector whose z points ahead (+x)."""
    return frame((x, y, z), x=(0, 1, 0), z=(1, 0, 0))


def quadruped_document():
    """18 parts, 12 joints: abduction, hip and knee of each leg; feet are fastened. An IMU's connector."""
    document = Document("Quadruped")
    studio = document.studio("Body")
    trunk = studio.part("Trunk", solids.box(0.30, 0.12, 0.07), ABS, BLUE)
    lid = studio.part("Lid", solids.box(0.20, 0.08, 0.01), ALUMINIUM, GREY)
    legs = document.studio("Legs")
    hip = legs.part("Hip", solids.box(0.05, 0.05, 0.05), ALUMINIUM, GREY)
    thigh = legs.part("Thigh", solids.box(0.03, 0.02, THIGH, at=(0, 0, -THIGH / 2)), ABS, BLUE)
    shank = legs.part("Shank", solids.box(0.02, 0.016, SHANK, at=(0, 0, -SHANK / 2)), ABS, GREY)
    foot = legs.part("Foot", solids.ball(FOOT), RUBBER, BLACK)

    dog = document.assembly("Quadruped")
    document.root = dog
    body = dog.add(trunk, pose=frame((0, 0, 0.4)))
    top = dog.add(lid)
    dog.fasten("Lid on trunk", (top, frame()), (body, frame((0, 0, 0.045))))
    for name, (ahead, left) in LEGS.items():
        hip_path = dog.add(hip, name=f"{name} hip")
        at = roll(0.11 * ahead, 0.095 * left, 0)
        dog.revolute(f"{name} abduction", (hip_path, roll()), (body, at), 0.0, (-0.6, 0.6))
        upper = dog.add(thigh, name=f"{name} thigh")
        side = pitch(0, 0.04 * left, 0)
        dog.revolute(f"{name} hip", (upper, pitch()), (hip_path, side), BEND, (-0.6, 1.6))
        lower = dog.add(shank, name=f"{name} shank")
        knee = pitch(0, 0, -THIGH)
        dog.revolute(f"{name} knee", (lower, pitch()), (upper, knee), -2 * BEND, (-2.4, -0.2))
        end = dog.add(foot, name=f"{name} foot")
        dog.fasten(f"{name} foot on", (end, frame()), (lower, frame((0, 0, -SHANK))))
    dog.connector("IMU", body, turn((0, 0, 1), math.pi / 2))
    document.truth.check()
    return document


YAML = """\
# @package _global_
defaults: [/robot/legged, override /source: bundle, override /actuators: position]
source:
  path: boxes.zip
name: quadruped
joints:
  "*": {damping: 0.1, armature: 0.005, effort: 12, velocity: 20}
"""
"""A robot's file; the bundle is where the command runs."""


def write_quadruped(folder):
    """Writes the document's bundle and the robot `boxes`, as a user has them."""
    document = quadruped_document()
    write_robot(folder, "boxes", document, YAML)
    return document
