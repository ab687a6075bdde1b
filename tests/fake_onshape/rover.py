"""The rover: two driven wheels, a ball caster, a lift with a gripper of two fingers, and a camera that tilts.

No part is fixed, so its base floats. A LINEAR relation makes the fingers slide apart alike.
"""

from tests.fake_onshape import rover_parts as shapes
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.rover_parts import AXLE, BALL, BALL_AT, DECK, FLOOR, MAST, MAST_AT, OPEN, WHEEL

UP = 0.160
"""How far the lift goes [m]."""

LOOK = 0.45
"""How far the camera looks down in the saved pose [rad]."""


def across(x=0.0, y=0.0, z=0.0):
    """A mate connector whose z is to the left (+y): a positive turn of a wheel drives ahead."""
    return frame((x, y, z), x=(1, 0, 0), z=(0, 1, 0))


def rover_document():
    """The robot: 26 parts, 7 joints, one of them a ball mate, one relation. Connectors at camera and tool."""
    document = Document("Rover")
    rover = document.assembly("Rover")
    document.root = rover
    parts = shapes.chassis_parts(document.studio("Chassis"))
    lift = shapes.lift_parts(document.studio("Lift"))
    wheel = _wheel(document)

    chassis = rover.add(parts["Chassis"], pose=frame((0, 0, FLOOR)))
    deck = rover.add(parts["Deck"])
    rover.fasten("Deck on chassis", (deck, frame()), (chassis, frame((0, 0, DECK - 0.006 - FLOOR))))
    for name, at in (("Computer", (-0.035, 0, 0.006)), ("Stop button", (-0.105, 0.0, 0.006))):
        rover.fasten(f"{name} on deck", (rover.add(parts[name]), frame()), (deck, frame(at)))
    bumper = rover.add(parts["Bumper"])
    rover.fasten("Bumper on", (bumper, frame()), (chassis, frame((0.112, 0, 0.010))))
    for side, name in ((1, "Left"), (-1, "Right")):
        driven = rover.add(wheel, name=f"{name} wheel")
        at = across(AXLE[0], side * AXLE[1], WHEEL - FLOOR)
        # The wheel's own y is outside: on the right it is turned about.
        outward = across() if side > 0 else frame(x=(-1, 0, 0), z=(0, -1, 0))
        rover.revolute(f"{name} drive", (driven / wheel.rim, outward), (chassis, at))
    socket, ball = rover.add(parts["Caster socket"]), rover.add(parts["Caster ball"])
    under = frame((BALL_AT, 0, BALL - FLOOR))
    rover.fasten("Socket on chassis", (socket, frame()), (chassis, under))
    rover.ball("Caster", (ball, frame()), (socket, frame()))

    mast = rover.add(lift["Mast"])
    rover.fasten("Mast on deck", (mast, frame((0, 0, -0.006))), (deck, frame((MAST_AT, 0, 0.006))))
    head = rover.add(lift["Mast head"])
    rover.fasten("Head on mast", (head, frame()), (mast, frame((0, 0, MAST))))
    carriage = rover.add(lift["Carriage"])
    rover.slider("Lift", (carriage, frame()), (mast, frame((0, 0, 0.034))), 0.030, (0.0, UP))
    _gripper(rover, lift, carriage)
    _camera(document, rover, head)
    rover.connector("IMU", chassis, frame((0, 0, 0.030)))
    document.truth.check()
    return document


def _wheel(document):
    """A tyre on its rim; `rim` is the rim."""
    parts = shapes.wheel_parts(document.studio("Wheel"))
    wheel = document.assembly("Wheel")
    wheel.rim = wheel.add(parts["Rim"])
    wheel.fasten("Tyre on rim", (wheel.add(parts["Tyre"]), frame()), (wheel.rim, frame()))
    return wheel


def _gripper(rover, parts, carriage):
    """Two fingers that slide apart on the carriage; positive values open both."""
    body = rover.add(parts["Gripper body"])
    rover.fasten("Gripper on carriage", (body, frame()), (carriage, frame((0.0475, 0, -0.015))))
    mates = []
    for side, name in ((1, "Left"), (-1, "Right")):
        finger = rover.add(parts["Finger"], name=f"{name} jaw")
        # Slides go outwards; the right finger is the left one, turned about x.
        outward = frame((0, 0, 0.012), x=(1, 0, 0), z=(0, 1, 0))
        way = frame((0.023, 0, 0.015), x=(1, 0, 0), z=(0, side, 0))
        mates.append(rover.slider(f"{name} finger", (finger, outward), (body, way), 0.025, (0.0, OPEN)))
        pad = rover.add(parts["Finger pad"])
        rover.fasten(f"{name} pad on finger", (pad, frame()), (finger, frame()))
    rover.linear("Finger coupling", *mates, reverse=True)
    rover.connector("Tool", body, frame((0.092, 0, 0.015), x=(0, 1, 0), z=(1, 0, 0)))


def _camera(document, rover, head):
    """A stereo camera in a yoke on the mast's head; its connector looks along z, with y down."""
    parts = shapes.camera_parts(document.studio("Camera"))
    yoke, camera = rover.add(parts["Yoke"]), rover.add(parts["Stereo camera"])
    rover.fasten("Yoke on head", (yoke, frame((0, 0, -0.026))), (head, frame((0, 0, 0.018))))
    rover.revolute("Camera tilt", (camera, across()), (yoke, across()), LOOK, (-0.5, 0.9))
    rover.connector("Camera", camera, frame((0.015, 0.010, 0), x=(0, -1, 0), z=(1, 0, 0)))
