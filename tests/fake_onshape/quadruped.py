"""The quadruped of the gallery: a trunk on four legs of three servos each, drawn standing with bent knees.

`quadruped_document().root` floats: no part is fixed. Closed forms for tests: `STANCE` is how far a foot's
lowest point is below the hips' axes.
"""

import math

from tests.fake_onshape import quadruped_parts as shapes
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.sample_parts import ABS, ALUMINIUM, RUBBER

__all__ = ["ABS", "ALUMINIUM", "BEND", "LEGS", "RUBBER", "STANCE", "pitch", "quadruped_document", "roll"]

BEND = 0.6
"""How far the thighs lean back, and the shanks forward [rad]."""

STANCE = (shapes.THIGH + shapes.SHANK) * math.cos(BEND) + shapes.FOOT

LEGS = {"Front left": (1, 1), "Front right": (1, -1), "Rear left": (-1, 1), "Rear right": (-1, -1)}
"""Where each leg is: ahead (1) or behind, left (1) or right."""

HIPS = (0.093, 0.046)
"""The horns of the trunk's servos: ahead and to the left of its middle [m]."""

AXIS = 0.057  # from a hip bracket's back to the axis of the thigh
ASIDE = 0.058  # from the axis of a hip to the middle of the leg


def pitch(x=0.0, y=0.0, z=0.0):
    """A mate connector whose z is across the robot (+y): a positive turn moves what hangs down backwards."""
    return frame((x, y, z), x=(1, 0, 0), z=(0, 1, 0))


def roll(x=0.0, y=0.0, z=0.0):
    """A mate connector whose z points ahead (+x)."""
    return frame((x, y, z), x=(0, 1, 0), z=(1, 0, 0))


def quadruped_document():
    """42 parts, 12 joints: abduction, hip and knee of each leg; feet are fastened. An IMU's connector."""
    document = Document("Quadruped")
    servo = shapes.servo_part(document.library("Dynamixel servos").studio("MX-106"))
    dog = document.assembly("Quadruped")
    document.root = dog
    trunk = _trunk(document, dog, servo)
    parts = shapes.leg_parts(document.studio("Legs"))
    for name, (ahead, left) in LEGS.items():
        bracket = dog.add(parts["Hip bracket"], name=f"{name} bracket")
        # Behind, the bracket is turned about: its own x points backwards.
        axis = frame(x=(0, ahead, 0), z=(ahead, 0, 0))
        place = roll(HIPS[0] * ahead, HIPS[1] * left, -shapes.CENTRE)
        dog.revolute(f"{name} abduction", (bracket, axis), (trunk, place), 0.0, (-0.6, 0.6))
        motor = dog.add(servo, name=f"{name} hip servo")
        mount = frame((AXIS, 0, 0), x=(1, 0, 0), z=(0, ahead * left, 0))
        dog.fasten(f"{name} hip servo mount", (motor, frame()), (bracket, mount))
        thigh = dog.add(parts["Thigh frame"], name=f"{name} thigh")
        side = frame((AXIS, ASIDE * ahead * left, 0), x=(ahead, 0, 0), z=(0, ahead, 0))
        dog.revolute(f"{name} hip", (thigh, pitch()), (bracket, side), BEND, (-1.0, 1.7))
        cover = dog.add(parts["Thigh cover"], name=f"{name} thigh cover")
        dog.fasten(f"{name} thigh cover on", (cover, frame()), (thigh, frame()))
        motor = dog.add(servo, name=f"{name} knee servo")
        mount = frame((0, 0, -shapes.THIGH), x=(0, 0, -1), z=(0, left, 0))
        dog.fasten(f"{name} knee servo mount", (motor, frame()), (thigh, mount))
        shank = dog.add(parts["Shank"], name=f"{name} shank")
        knee = pitch(0, 0, -shapes.THIGH)
        dog.revolute(f"{name} knee", (shank, pitch()), (thigh, knee), -2 * BEND, (-2.3, -0.3))
        foot = dog.add(parts["Foot"], name=f"{name} foot")
        dog.fasten(f"{name} foot on", (foot, frame()), (shank, frame((0, 0, -shapes.SHANK))))
        dog.connector(f"{name} foot", foot, frame())
    document.truth.check()
    return document


def _trunk(document, dog, servo):
    """The trunk with the servos of the hips, its head, battery and electronics; returns its shell."""
    parts = shapes.trunk_parts(document.studio("Trunk"), HIPS[1])
    length = shapes.HALF_LENGTH
    shell = dog.add(parts["Trunk"], pose=frame())

    def fasten(part, name, place):
        occurrence = dog.add(parts[part], name=name)
        dog.fasten(f"{name} on", (occurrence, frame()), (shell, place))
        return occurrence

    fasten("Trim", "Front trim", frame((length - 0.012, 0, 0)))
    fasten("Trim", "Rear trim", frame((-length, 0, 0)))
    fasten("Bulkhead", "Front bulkhead", frame((length, 0, 0)))
    fasten("Bulkhead", "Rear bulkhead", frame((-length, 0, 0), x=(-1, 0, 0), z=(0, 0, 1)))
    fasten("Battery", "Battery", frame((0, 0, -0.0375)))
    fasten("Computer", "Computer", frame((0, 0, 0.012)))
    imu = fasten("IMU module", "IMU module", frame((0, 0, 0.020)))
    fasten("Head", "Head", frame((length - 0.010, 0, 0.0425)))
    fasten("Handle", "Handle", frame((-0.020, 0, 0.044)))
    dog.connector("IMU", imu, frame())
    for name, (ahead, left) in LEGS.items():
        motor = dog.add(servo, name=f"{name} abduction servo")
        middle = ahead * (shapes.HALF_LENGTH - shapes.DEPTH / 2)
        place = frame((middle, HIPS[1] * left, -shapes.CENTRE), x=(0, 0, -1), z=(ahead, 0, 0))
        dog.fasten(f"{name} abduction servo mount", (motor, frame()), (shell, place))
    return shell
