"""The delta robot: three driven arms, six rods between balls, and a platform that never turns.

Closed forms for tests: `arm_angles(xyz)` are the arms' values at which the platform is at a place.
"""

import math

from tests.fake_onshape import delta_parts as shapes
from tests.fake_onshape.delta_parts import ARM, HALF, LIMBS, MOTOR, PLATFORM, ROD
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame, product, turn

AXES = shapes.BASE + shapes.COLUMN - shapes.HANG
"""Height of the motors' axes above the ground [m]."""

LIMITS = (-0.4, 1.0)
"""Limits of an arm [rad]: 0 is horizontal, positive is down."""

SAVED = 0.25


def depth(value=SAVED):
    """How far the platform's balls are below the motors' axes where all arms have one value [m]."""
    apart = MOTOR + ARM * math.cos(value) - PLATFORM
    return ARM * math.sin(value) + math.sqrt(ROD**2 - apart**2)


def arm_angles(xyz):
    """The values [rad] of the three arms with the platform's centre at `xyz` [m], in the robot's frame.

    In a limb's plane the rod's end is at (x, z) from the motor's axis and y beside it. The elbow is at
    ARM·(cos q, −sin q), ROD from there: x·cos q − z·sin q = (x² + y² + z² + ARM² − ROD²) / (2·ARM).
    """
    angles = []
    for number in range(LIMBS):
        turned = product(turn((0, 0, 1), -math.tau * number / LIMBS), frame(xyz))
        x, y, z = turned[:3, 3] + (PLATFORM - MOTOR, 0.0, -AXES)
        wanted = (x * x + y * y + z * z + ARM**2 - ROD**2) / (2 * ARM)
        angles.append(math.atan2(-z, x) - math.acos(wanted / math.hypot(x, z)))
    return angles


def delta_document():
    """The robot: 27 parts, 3 hinges, 12 ball mates, five of which close loops. A connector at the tool."""
    document = Document("Delta robot")
    robot = document.assembly("Delta robot")
    document.root = robot
    parts = shapes.frame_parts(document.studio("Frame"))
    limb = shapes.limb_parts(document.studio("Limb"))
    end = shapes.platform_parts(document.studio("Platform"))

    top = _stand(robot, parts)
    lean = math.asin((MOTOR + ARM * math.cos(SAVED) - PLATFORM) / ROD)
    platform = robot.add(end["Platform"])
    for number in range(LIMBS):
        around = turn((0, 0, 1), math.tau * number / LIMBS)
        axis = product(around, frame((MOTOR, 0, -shapes.HANG)))
        for name in ("Motor", "Bearing block"):
            robot.fasten(f"{name} {number + 1}", (robot.add(parts[name]), frame()), (top, axis))
        arm = robot.add(limb["Arm"], name=f"Arm {number + 1}")
        hinge = frame(x=(1, 0, 0), z=(0, 1, 0))
        robot.revolute(f"Shoulder {number + 1}", (arm, hinge), (top, product(axis, hinge)), SAVED, LIMITS)
        for side, name in ((-1, "right"), (1, "left")):
            rod = robot.add(limb["Rod"], name=f"Rod {number + 1} {name}")
            elbow = frame((ARM, side * HALF, 0))
            robot.ball(f"Elbow {number + 1} {name}", (rod, turn((0, 1, 0), SAVED - lean)), (arm, elbow))
            at = product(around, frame((PLATFORM, side * HALF, 0)))
            lower = turn((0, 1, 0), -lean, (0, 0, -ROD))
            closing = (number, side) != (0, -1)
            robot.ball(f"Wrist {number + 1} {name}", (platform, at), (rod, lower), closing=closing)
    cup = robot.add(end["Suction cup"])
    robot.fasten("Cup on platform", (cup, frame()), (platform, frame()))
    robot.connector("Tool", cup, frame((0, 0, -shapes.TOOL), x=(1, 0, 0), z=(0, 0, -1)))
    document.truth.check()
    return document


def _stand(robot, parts):
    """Adds what stands still; returns the top plate, whose frame is at the middle of its lower side."""
    base = robot.add(parts["Base"], fixed=True)
    mat = robot.add(parts["Work mat"])
    robot.fasten("Mat on base", (mat, frame()), (base, frame((0, 0, shapes.BASE))))
    top = robot.add(parts["Top plate"])
    for number, (x, y) in enumerate(shapes.columns(), 1):
        column = robot.add(parts["Column"])
        robot.fasten(f"Column {number}", (column, frame()), (base, frame((x, y, shapes.BASE))))
        foot = robot.add(parts["Column foot"])
        robot.fasten(f"Column foot {number}", (foot, frame()), (column, frame()))
        if number == 1:
            robot.fasten("Top plate on", (top, frame((x, y, 0))), (column, frame((0, 0, shapes.COLUMN))))
    cover = robot.add(parts["Cover"])
    robot.fasten("Cover on", (cover, frame()), (top, frame((0, 0, shapes.TOP))))
    return top
