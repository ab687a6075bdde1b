"""The parts of the delta robot, each in a natural frame of its own. Metres; colours 0..255.

What belongs to a limb lies in the x–z plane: x points away from the robot's axis, y is across the limb.
"""

import math

import numpy as np

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.frames import frame, turn
from tests.fake_onshape.sample_parts import pin, slab

ALUMINIUM, STEEL, ABS, RUBBER, CARBON = 2700.0, 7850.0, 1040.0, 1150.0, 1600.0  # kg/m³

WHITE, GRAPHITE, BLUE = (238, 240, 242), (52, 56, 62), (31, 111, 198)
SILVER, STEEL_GREY, BLACK, MAT = (189, 193, 198), (148, 153, 158), (28, 29, 31), (206, 222, 238)

LIMBS = 3
MOTOR, ARM, ROD, PLATFORM = 0.085, 0.140, 0.300, 0.040
"""Radius of the motors' axes, lengths of arm and rod, radius of the platform's balls [m]."""

HALF = 0.030
"""Half the distance of the two rods of a limb [m]."""

COLUMN, COLUMN_AT = 0.484, 0.250
"""Height of the columns, and their distance from the robot's axis [m]."""

BASE, TOP = 0.012, 0.014
"""Thickness of the base and of the top plate [m]."""

HANG = 0.030
"""How far the motors' axes are below the top plate [m]."""

TOOL = 0.046
"""How far the tip of the suction cup is below the platform's balls [m]."""


def _between(number):
    """The angle [rad] of a column, halfway between two limbs."""
    return outlines.TURN * (number + 0.5) / LIMBS


def columns():
    """Where the columns are: (x, y) each."""
    angles = [_between(number) for number in range(LIMBS)]
    return [(COLUMN_AT * math.cos(angle), COLUMN_AT * math.sin(angle)) for angle in angles]


def _spider(hub, width, corners=8):
    """The outline of a round hub with a spoke of round end to each column."""
    points = []
    for number in range(LIMBS):
        angle = _between(number)
        ends = angle + outlines.TURN / 4 * np.linspace(-1, 1, corners + 1)
        end = np.array([math.cos(angle), math.sin(angle)]) * COLUMN_AT
        points.append(end + width * np.column_stack([np.cos(ends), np.sin(ends)]))
        free = math.asin(width / hub) + 0.05
        rim = np.linspace(angle + free, angle + outlines.TURN / LIMBS - free, 2 * corners + 1)
        points.append(hub * np.column_stack([np.cos(rim), np.sin(rim)]))
    return np.concatenate(points)


def frame_parts(studio):
    """Base, work mat, column, top plate, cover, and what carries an arm; returned by name."""
    corners = [outlines.circle(0.042, at, 32) for at in columns()]
    base = solids.extrude(outlines.hull(*corners), BASE, 0.0025)
    studio.part("Base", base, STEEL, GRAPHITE, {"chamfer": SILVER})
    mat = solids.cylinder(0.125, 0.004, 0.0015, 48)
    studio.part("Work mat", mat, RUBBER, MAT, {"face 1": BLUE, "face 2": BLUE, "face 3": BLUE})
    studio.part("Column", solids.tube(0.011, 0.008, COLUMN, 0, 24), ALUMINIUM, SILVER)
    studio.part("Column foot", solids.tube(0.017, 0.011, 0.016, 0.002, 24), ABS, BLUE)
    screws = [outlines.circle(0.0035, at, 12) for at in columns()]
    plate = solids.extrude(_spider(0.112, 0.024), TOP, 0.0025, screws)
    studio.part("Top plate", plate, ABS, WHITE, {"chamfer": SILVER})
    dome = [(0, 0), (0.070, 0), (0.070, 0.012), (0.062, 0.024), (0.045, 0.031), (0.020, 0.035), (0, 0.036)]
    studio.part("Cover", solids.revolve(dome, 40), ABS, GRAPHITE, {"face 2": BLUE}, mass=0.12)
    body = outlines.rounded_rectangle(0.046, 0.048, 0.005, (-0.008, HANG - 0.024), 4)
    case = slab(body, 0.014, 0.054, 0.0015) + pin(0.0125, 0.0085, 0.014, segments=24).named("horn")
    label = outlines.rounded_rectangle(0.022, 0.016, 0.003, (-0.008, HANG - 0.024), 4)
    case += slab(label, 0.054, 0.0548).named("label")
    colours = case.painted(STEEL_GREY, "horn") | case.painted(BLUE, "label")
    studio.part("Motor", case, ABS, GRAPHITE, colours, mass=0.153)
    cheek = outlines.hull(outlines.circle(0.013, segments=24), [(-0.017, HANG), (0.017, HANG)])
    bearing = slab(cheek, -0.019, -0.0105, 0.001)
    bearing += pin(0.007, -0.0105, -0.0085).named("stud") + pin(0.008, -0.0205, -0.019).named("cap")
    studio.part("Bearing block", bearing, ALUMINIUM, GRAPHITE, bearing.painted(STEEL_GREY, "stud", "cap"))
    return {part.name: part for part in studio.parts}


def limb_parts(studio):
    """Arm and rod; returned by name."""
    tip = (ARM, 0.0)
    beam = outlines.hull(outlines.circle(0.017), outlines.circle(0.0095, tip, 24))
    slots = [outlines.stroke([(0.036, 0), (0.076, 0)], 0.0065), outlines.circle(0.0048, (0.104, 0), 16)]
    arm = slab(beam, -0.0085, 0.0085, 0.002, [*slots, outlines.circle(0.0055, segments=16)])
    for side in (-1, 1):
        name, end = ("left", "right")[side > 0], side * (HALF - 0.006)
        arm += pin(0.0045, *sorted((side * 0.0085, end)), tip, segments=16).named(f"{name} stud")
        arm += solids.ball(0.0075, 16, 8).moved(frame((ARM, side * HALF, 0))).named(f"{name} ball")
    colours = arm.painted(STEEL_GREY, "stud", "ball") | {"hole 0": BLUE, "hole 1": BLUE}
    studio.part("Arm", arm, ABS, WHITE, colours)

    rod = solids.cylinder(0.0042, ROD - 0.030, 0, 16).moved(frame((0, 0, 0.015 - ROD))).named("tube")
    for name, z in (("upper", 0.0), ("lower", -ROD)):
        inward = -1 if name == "upper" else 1
        ring = solids.tube(0.0105, 0.0077, 0.008, 0.001, 20).moved(frame((0, 0.004, z), z=(0, -1, 0)))
        start = z + inward * 0.0103
        sleeve = solids.cylinder(0.0062, 0.014, 0.001, 16)
        low = start if inward > 0 else start - 0.014
        rod += ring.named(name) + sleeve.moved(frame((0, 0, low))).named(f"{name} sleeve")
    studio.part("Rod", rod, CARBON, BLACK, rod.painted(BLUE, "upper", "lower"))
    return {part.name: part for part in studio.parts}


def platform_parts(studio):
    """Platform, with a pair of balls to each limb, and suction cup; returned by name."""
    corners, balls = [], None
    for number in range(LIMBS):
        angle = outlines.TURN * number / LIMBS
        away, across = (math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))
        for side in (-1, 1):
            at = [0.034 * a + side * 0.017 * b for a, b in zip(away, across, strict=True)]
            corners.append(outlines.circle(0.011, at, 24))
        axle = pin(0.0042, 0.006 - HALF, HALF - 0.006, (PLATFORM, 0.0), segments=16).named("axle")
        for side in (-1, 1):
            axle += solids.ball(0.0075, 16, 8).moved(frame((PLATFORM, side * HALF, 0))).named("ball")
        axle = axle.moved(turn((0, 0, 1), angle)).named(f"{number}")
        balls = axle if balls is None else balls + axle
    plate = solids.extrude(outlines.hull(*corners), 0.012, 0.002).moved(frame((0, 0, -0.006)))
    hub = solids.cylinder(0.017, 0.008, 0.001, 28).moved(frame((0, 0, 0.006))).named("hub")
    colours = hub.painted(BLUE) | balls.painted(STEEL_GREY) | {"chamfer": SILVER}
    studio.part("Platform", plate + hub + balls, ALUMINIUM, WHITE, colours)

    profile = [(0, -0.006), (0, -TOOL), (0.014, -TOOL), (0.0105, -0.0385), (0.0125, -0.0345)]
    profile += [(0.0095, -0.0305), (0.0055, -0.0285), (0.0055, -0.018), (0.009, -0.016), (0.009, -0.006)]
    cup = solids.revolve(profile, 28)
    metal = {f"face {number}": STEEL_GREY for number in (6, 7, 8)}
    studio.part("Suction cup", cup, RUBBER, BLUE, metal)
    return {part.name: part for part in studio.parts}
