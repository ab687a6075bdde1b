"""The sample robot: a desk arm with a lift, a parallel linkage and a two-finger gripper."""

import math

from tests.fake_onshape import sample_parts as shapes
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame, turn

LEAN = 0.38  # rad: how far the upper arm leans forward in the saved pose


def pitch(x=0.0, y=0.0, z=0.0):
    """A mate connector whose z is across the arm (+y): a positive turn leans forward."""
    return frame((x, y, z), x=(1, 0, 0), z=(0, 1, 0))


def sample_document():
    """The desk arm: 28 parts, 10 joints, one loop, one gear relation, a servo used twice."""
    document = Document("Desk arm")
    arm = document.assembly("Desk arm")
    document.root = arm
    servo = _servo(document.library("Servo library"))
    gripper, palm = _gripper(document)
    base = shapes.base_parts(document.studio("Base"))
    parts = shapes.arm_parts(document.studio("Arm"))

    plate = arm.add(base["Base plate"], fixed=True, pose=frame((0, 0, 0.006)))
    for number, (x, y) in enumerate([(0.072, 0.052), (-0.072, 0.052), (-0.072, -0.052), (0.072, -0.052)], 1):
        foot = arm.add(base["Foot"])
        arm.fasten(f"Foot {number}", (foot, frame()), (plate, frame((x, y, -0.006))))
    sleeve = arm.add(base["Column sleeve"])
    arm.fasten("Sleeve on plate", (sleeve, frame()), (plate, frame((0, 0, 0.012))))
    column = arm.add(base["Lift column"])
    arm.slider("Lift", (column, frame()), (plate, frame((0, 0, 0.016))), 0.022, (0.0, 0.05))
    table = arm.add(base["Turntable"])
    arm.fasten("Turntable on column", (table, frame()), (column, frame((0, 0, shapes.COLUMN))))

    turret = arm.add(parts["Turret"])
    yaw = frame((0, 0, shapes.COLUMN + 0.012))
    arm.revolute("Shoulder yaw", (turret, frame()), (column, yaw), 0.5, (-2.6, 2.6))
    shoulder_servo = arm.add(servo)
    mount = frame((0, -0.035, shapes.SHOULDER[2]), x=(0, 0, 1), z=(0, 1, 0))
    arm.fasten("Shoulder servo mount", (shoulder_servo / servo.case, frame()), (turret, mount))

    upper = arm.add(parts["Upper arm"])
    arm.revolute("Shoulder", (upper, pitch()), (turret, pitch(*shapes.SHOULDER)), LEAN, (-0.5, 1.1))
    trim = arm.add(parts["Upper arm trim"])
    arm.fasten("Upper arm trim on", (trim, frame()), (upper, frame()))
    rod = arm.add(parts["Parallel rod"])
    lower = pitch(shapes.ROD[0], 0.0, shapes.SHOULDER[2] + shapes.ROD[2])
    arm.revolute("Rod lower pivot", (turret, lower), (rod, pitch()), -LEAN, (-1.1, 0.5))
    link = arm.add(parts["Elbow plate"])
    top = pitch(0, 0, shapes.UPPER_ARM)
    arm.revolute("Elbow plate pivot", (link, pitch()), (upper, top), -LEAN, (-1.1, 0.5))
    # The one mate without limits: the other three bound the linkage, and it closes it.
    arm.revolute("Rod upper pivot", (rod, top), (link, pitch(*shapes.ROD)), LEAN, closing=True)

    forearm = arm.add(parts["Forearm"])
    arm.revolute("Elbow", (forearm, pitch()), (link, pitch(*shapes.ELBOW)), 0.25, (-0.6, 1.3))
    elbow_servo = arm.add(servo)
    mount = frame((shapes.ELBOW[0], 0.018, shapes.ELBOW[2]), x=(1, 0, 0), z=(0, -1, 0))
    arm.fasten("Elbow servo mount", (elbow_servo / servo.case, frame()), (link, mount))
    trim = arm.add(parts["Forearm trim"])
    arm.fasten("Forearm trim on", (trim, frame()), (forearm, frame()))

    wrist = arm.add(parts["Wrist"])
    tip = pitch(shapes.FOREARM, 0, 0)
    arm.revolute("Wrist pitch", (forearm, tip), (wrist, pitch()), -0.65, (-1.6, 1.6))
    hand = arm.add(gripper)
    flange = frame((0.046, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    arm.revolute("Wrist roll", (hand / palm, frame()), (wrist, flange), 0.3, (-2.6, 2.6))
    arm.connector("Tool", hand / palm, frame((0, 0, 0.104)))
    document.truth.check()
    return document


def _servo(library):
    """A servo of two parts, from a document of its own; `case` is its case."""
    parts = shapes.servo_parts(library.studio("Servo"))
    servo = library.assembly("Servo")
    servo.case = servo.add(parts["Servo case"])
    bearing = servo.add(parts["Servo bearing"])
    servo.fasten("Bearing in case", (bearing, frame()), (servo.case, frame((0, 0, -0.003))))
    return servo


def _gripper(document):
    """Two fingers that gears turn against each other; returns the assembly and its palm."""
    parts = shapes.gripper_parts(document.studio("Gripper"))
    finger = document.assembly("Finger")
    body = finger.add(parts["Jaw"])
    pad = finger.add(parts["Finger pad"])
    finger.fasten("Pad on jaw", (pad, frame()), (body, frame()))

    gripper = document.assembly("Gripper")
    palm = gripper.add(parts["Palm"])
    camera = gripper.add(parts["Camera"])
    gripper.fasten("Camera on palm", (camera, frame()), (palm, frame((0, 0.020, 0.006))))
    x, _, z = shapes.PIVOT
    left, right = (gripper.add(finger, name=f"{side} finger") for side in ("Left", "Right"))
    for_left, for_right = pitch(), frame(x=(-1, 0, 0), z=(0, -1, 0))
    opening = (-0.145, 0.6)  # at -0.143 the tips of the pads meet
    opens = gripper.revolute("Left finger", (left / body, for_left), (palm, pitch(x, 0, z)), 0.22, opening)
    closing = (-opening[1], -opening[0])
    shuts = gripper.revolute(
        "Right finger", (right / body, for_right), (palm, pitch(-x, 0, z)), -0.22, closing
    )
    gripper.gear("Finger gears", opens, shuts, 1.0)
    # The right wheel is turned by half a tooth, so that the teeth mesh.
    for name, side, at in (("Left", left, frame()), ("Right", right, half_tooth())):
        wheel = gripper.add(parts["Finger gear"])
        gripper.fasten(f"{name} gear", (wheel, frame()), (side / body, at))
    return gripper, palm


def half_tooth():
    """The right wheel's place on its finger: a turn by half a tooth about the pivot."""
    return turn((0, 1, 0), math.pi / shapes.TEETH)
