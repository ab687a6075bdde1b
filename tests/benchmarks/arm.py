"""An arm of 11 finely tessellated parts: a base, six hinges, and a hand with two jaws."""

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.bundle import write_robot
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.quadruped import ABS, ALUMINIUM, pitch

PARTS = 11

ROUND = 1500
"""Corners around each cylinder."""

SHOULDER, UPPER, FOREARM, WRIST = 0.18, 0.305, 0.255, 0.045
"""The height of the shoulder, and the lengths from axis to axis and to the palm [m]."""


def _rod(radius, height):
    return solids.cylinder(radius, height, 0.002, ROUND)


def arm_document():
    document = Document("Arm")
    studio = document.studio("Arm")
    arm = document.assembly("Arm")
    document.root = arm

    def part(name, shape, density=ALUMINIUM):
        return arm.add(studio.part(name, shape, density), name=name)

    base = arm.add(studio.part("Base", _rod(0.08, 0.05), ABS), name="Base", fixed=True, pose=frame())
    turret = part("Turret", _rod(0.06, 0.07))
    arm.revolute("Yaw", (turret, frame((0, 0, -0.005))), (base, frame((0, 0, 0.05))), 0.0, (-2.9, 2.9))
    carrier, height = turret, SHOULDER - 0.055
    for joint, limb, radius, length, turn, limits in (
        ("Shoulder", "Upper arm", 0.03, UPPER, 0.4, (-1.8, 1.8)),
        ("Elbow", "Forearm", 0.025, FOREARM, 0.9, (-0.3, 2.3)),
        ("Wrist", "Flange", 0.02, WRIST + 0.03, 0.6, (-1.8, 1.8)),
    ):
        motor = part(f"{joint} motor", _rod(radius + 0.005, 0.05))
        arm.fasten(f"{joint} motor on", (motor, frame((0, 0, 0.025))), (carrier, pitch(0, 0, height)))
        # A limb begins beyond the motor that turns it, and ends before the next one.
        gap = radius + 0.015
        rod = part(limb, _rod(radius, length - 2 * gap))
        arm.revolute(joint, (rod, pitch(0, 0, -gap)), (carrier, pitch(0, 0, height)), turn, limits)
        carrier, height = rod, length - gap
    outline = outlines.rounded_rectangle(0.11, 0.05, 0.015, segments=300)
    palm = part("Palm", solids.extrude(outline, 0.03, 0.001), ABS)
    at = frame((0, 0, WRIST + 0.03 - 2 * 0.035 + 0.004))
    arm.revolute("Roll", (palm, frame()), (carrier, at), 0.0, (-3.0, 3.0))
    jaw = studio.part(
        "Jaw", solids.extrude(outlines.rounded_rectangle(0.012, 0.03, 0.004, segments=300), 0.06), ALUMINIUM
    )
    for name, side in (("Left", 1), ("Right", -1)):
        jaw_body = arm.add(jaw, name=f"{name} jaw")
        here, there = (
            frame((x, 0, z), x=(0, 1, 0), z=(side, 0, 0)) for x, z in ((0, 0), (side * 0.01, 0.033))
        )
        arm.slider(f"{name} slide", (jaw_body, here), (palm, there), 0.015, (0.0, 0.035))
    document.truth.check()
    return document


YAML = """\
# @package _global_
defaults: [/robot/bare, override /source: bundle, override /actuators: position]
source:
  path: arm.zip
name: arm
joints:
  "*": {damping: 0.5, armature: 0.01, effort: 40, velocity: 3}
"""


def write_arm(folder):
    """Writes the document's bundle and the robot `arm`, as a user has them."""
    write_robot(folder, "arm", arm_document(), YAML)
