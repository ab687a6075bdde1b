"""A quadruped of 58 parts in sub-assemblies: a slender trunk between wide plates, so that its hull is in the
way of the thighs, and legs of plates, tubes and motors.

Each leg is three sub-assemblies, of a hip, a thigh and a shank, on three hinges; the base floats.
"""

import math

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.bundle import write_robot
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.quadruped import ABS, ALUMINIUM, BEND, LEGS, RUBBER, pitch, roll

THIGH, SHANK, FOOT = 0.16, 0.15, 0.02
"""Lengths between axes, and the radius of a foot [m]."""

PARTS = 58


def walker_document():
    document = Document("Walker")
    trunk = _trunk(document)
    hip, thigh, shank = _hip(document), _thigh(document), _shank(document)
    walker = document.assembly("Walker")
    document.root = walker
    body = walker.add(trunk, pose=frame((0, 0, 0.45)))
    for name, (ahead, left) in LEGS.items():
        hip_body, upper, lower = (
            walker.add(part, name=f"{name} {part.name}") for part in (hip, thigh, shank)
        )
        at, side, knee = roll(0.13 * ahead, 0.055 * left, 0), pitch(0, 0.055 * left, 0), pitch(0, 0, -THIGH)
        ends = (hip_body / hip.holds, roll()), (body / trunk.holds, at)
        walker.revolute(f"{name} abduction", *ends, 0.0, (-0.7, 0.7))
        ends = (upper / thigh.holds, pitch()), (hip_body / hip.holds, side)
        walker.revolute(f"{name} hip", *ends, BEND, (-1.0, 2.0))
        ends = (lower / shank.holds, pitch()), (upper / thigh.holds, knee)
        walker.revolute(f"{name} knee", *ends, -2 * BEND, (-2.5, -0.3))
    document.truth.check()
    return document


def _trunk(document):
    """A spine between two plates, four motors in these, a lid, a battery and a mast: ten parts."""
    studio = document.studio("Trunk")
    across = solids.box(0.012, 0.22, 0.09)
    motor = studio.part("Abduction motor", solids.cylinder(0.026, 0.03, 0.002, 48), ALUMINIUM)
    trunk = document.assembly("Trunk")
    trunk.holds = trunk.add(studio.part("Spine", solids.box(0.40, 0.06, 0.05), ABS))
    for name, x in (("Front", 0.206), ("Rear", -0.206)):
        plate = trunk.add(studio.part(f"{name} plate", across, ALUMINIUM))
        trunk.fasten(f"{name} plate on", (plate, frame()), (trunk.holds, frame((x, 0, 0))))
        for side, y in (("left", 0.055), ("right", -0.055)):
            motor_body = trunk.add(motor, name=f"{name} {side} motor")
            ahead = math.copysign(1.0, x)
            at = frame((x - 0.041 * ahead, y, 0.0), x=(0, 1, 0), z=(ahead, 0, 0))
            trunk.fasten(f"{name} {side} motor on", (motor_body, frame()), (trunk.holds, at))
    for name, shape, z in (
        ("Lid", solids.box(0.30, 0.05, 0.006), 0.028),
        ("Battery", solids.box(0.16, 0.05, 0.03), -0.04),
        ("Mast", solids.tube(0.015, 0.012, 0.06, 0.001), 0.031),
    ):
        part = trunk.add(studio.part(name, shape, ABS))
        trunk.fasten(f"{name} on", (part, frame()), (trunk.holds, frame((0, 0, z))))
    return trunk


def _hip(document):
    """A bracket, a motor and its cap."""
    studio = document.studio("Hip")
    hip = document.assembly("Hip")
    hip.holds = hip.add(studio.part("Bracket", solids.box(0.05, 0.03, 0.04), ALUMINIUM))
    for name, radius, length, z in (("Hip motor", 0.024, 0.03, -0.015), ("Cap", 0.018, 0.006, 0.015)):
        part = hip.add(studio.part(name, solids.cylinder(radius, length, 0.002, 48), ALUMINIUM))
        hip.fasten(f"{name} on", (part, frame()), (hip.holds, pitch(0, z, 0)))
    return hip


def _thigh(document):
    """Two plates with slots, two spacers and the knee's motor."""
    studio = document.studio("Thigh")
    outline = outlines.stroke([(0.0, 0.0), (0.0, -THIGH)], 0.026)
    slot = outlines.stroke([(0.0, -0.04), (0.0, -0.11)], 0.010)
    plate = studio.part("Thigh plate", solids.extrude(outline, 0.004, 0.0005, [slot]), ALUMINIUM)
    spacer = studio.part("Spacer", solids.cylinder(0.006, 0.022, 0.0, 24), ALUMINIUM)
    motor = studio.part("Knee motor", solids.cylinder(0.024, 0.022, 0.002, 48), ALUMINIUM)
    thigh = document.assembly("Thigh")
    thigh.holds = thigh.add(spacer, name="Upper spacer")
    # The outline's y is the thigh's z, and it is drawn across, from y on.
    for name, y in (("Inner", -0.015), ("Outer", 0.011)):
        plate_body = thigh.add(plate, name=f"{name} plate")
        thigh.fasten(f"{name} plate on", (plate_body, frame()), (thigh.holds, _drawn(y)))
    lower = thigh.add(spacer, name="Lower spacer")
    thigh.fasten("Lower spacer on", (lower, frame()), (thigh.holds, frame((0, 0, -0.12))))
    knee = thigh.add(motor)
    thigh.fasten("Knee motor on", (knee, frame()), (thigh.holds, pitch(0, -0.011, -THIGH)))
    return thigh


def _drawn(y):
    """A frame in whose x and y an outline is one of the thigh's x and z, at y."""
    return frame((0, y + 0.004, 0), x=(1, 0, 0), z=(0, -1, 0))


def _shank(document):
    """A clamp, a tube, a mount for the foot, and the foot."""
    studio = document.studio("Shank")
    shank = document.assembly("Shank")
    shank.holds = shank.add(studio.part("Clamp", solids.box(0.024, 0.018, 0.04), ALUMINIUM))
    for name, shape, density, z in (
        ("Tube", solids.tube(0.008, 0.006, SHANK - 0.02, 0.0005), ALUMINIUM, -SHANK + 0.01),
        ("Mount", solids.cylinder(0.011, 0.016, 0.001), ABS, -SHANK),
        ("Foot", solids.ball(FOOT), RUBBER, -SHANK),
    ):
        part = shank.add(studio.part(name, shape, density))
        shank.fasten(f"{name} on", (part, frame()), (shank.holds, frame((0, 0, z))))
    return shank


YAML = """\
# @package _global_
defaults: [/robot/legged, override /source: bundle, override /actuators: position]
source:
  path: walker.zip
name: walker
joints:
  "*": {damping: 0.1, armature: 0.005, effort: 20, velocity: 20}
"""


def write_walker(folder):
    """Writes the document's bundle and the robot `walker`, as a user has them."""
    write_robot(folder, "walker", walker_document(), YAML)
