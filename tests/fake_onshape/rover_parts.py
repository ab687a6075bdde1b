"""The parts of the rover, each in a natural frame of its own: x ahead, y to the left. Metres; colours
0..255.
"""

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.frames import frame
from tests.fake_onshape.sample_parts import pin, slab

ALUMINIUM, STEEL, ABS, RUBBER = 2700.0, 7850.0, 1040.0, 1150.0  # kg/m³

YELLOW, GRAPHITE, WHITE = (246, 186, 30), (52, 56, 62), (238, 236, 230)
SILVER, STEEL_GREY, BLACK = (189, 193, 198), (148, 153, 158), (28, 29, 31)
GLASS, RED = (38, 66, 120), (196, 52, 44)

WHEEL, TYRE = 0.055, 0.030
"""Radius and width of a driven wheel [m]."""

AXLE = (0.055, 0.121)
"""Where the wheels' middles are: ahead of the chassis' middle, and beside it [m]."""

BALL, BALL_AT = 0.019, -0.115
"""Radius of the caster's ball; how far ahead of the chassis' middle it is [m]."""

FLOOR, DECK = 0.040, 0.098
"""Heights above the ground of the chassis' lower and of the deck's upper side [m]."""

MAST_AT, MAST = 0.112, 0.230
"""Where the mast is on the deck, and its height [m]."""

OPEN = 0.045
"""How far each finger's pad is from the middle where the fingers are at their widest [m]."""


def chassis_parts(studio):
    """Chassis, deck, bumper, computer, stop button, caster's socket and ball; returned by name."""
    height = DECK - 0.006 - FLOOR
    body = solids.extrude(outlines.rounded_rectangle(0.300, 0.196, 0.040, segments=6), height, 0.004)
    studio.part("Chassis", body, ABS, YELLOW, {"chamfer": GRAPHITE, "bottom": GRAPHITE}, mass=3.2)
    screws = [outlines.circle(0.003, (x, y), 12) for x in (-0.115, 0.115) for y in (-0.070, 0.070)]
    deck = solids.extrude(outlines.rounded_rectangle(0.270, 0.170, 0.030, segments=6), 0.006, 0.0015, screws)
    studio.part("Deck", deck, ALUMINIUM, GRAPHITE, {"chamfer": SILVER})
    rail = outlines.stroke([(0.020, -0.075), (0.045, -0.055), (0.045, 0.055), (0.020, 0.075)], 0.006, 8)
    studio.part("Bumper", solids.extrude(rail, 0.020, 0.002), RUBBER, BLACK)
    box = solids.extrude(outlines.rounded_rectangle(0.090, 0.110, 0.012, segments=5), 0.034, 0.004)
    for y in (-0.030, -0.015, 0.0, 0.015, 0.030):
        box += solids.box(0.060, 0.006, 0.0016, (0, y, 0.0348)).named("vent")
    studio.part("Computer", box, ABS, WHITE, box.painted(GRAPHITE, "vent"), mass=0.40)
    knob = [(0, 0), (0.010, 0), (0.010, 0.006), (0.0065, 0.007), (0.0065, 0.013), (0.011, 0.015)]
    knob += [(0.011, 0.020), (0.009, 0.022), (0, 0.022)]
    red = {f"face {number}": RED for number in (4, 5, 6, 7)}
    studio.part("Stop button", solids.revolve(knob, 24), ABS, GRAPHITE, red)
    cup = [(BALL + 0.0010, -0.004), (BALL + 0.0050, -0.004), (BALL + 0.0060, 0.004), (BALL + 0.0060, 0.022)]
    cup += [(0, 0.022), (0, BALL + 0.0015), (0.012, 0.0162), (BALL - 0.0005, 0.0080)]
    studio.part("Caster socket", solids.revolve(cup, 28), ABS, GRAPHITE)
    studio.part("Caster ball", solids.ball(BALL, 24, 12), STEEL, SILVER)
    return {part.name: part for part in studio.parts}


def wheel_parts(studio):
    """Tyre and rim; their axis is y, and +y is outside. Returned by name."""
    across = frame((0, 0, 0), x=(1, 0, 0), z=(0, 1, 0))
    half = TYRE / 2
    profile = [(0.040, -half), (WHEEL - 0.0022, -half), (WHEEL, 0.0022 - half), (WHEEL, -0.003)]
    profile += [(WHEEL - 0.0015, -0.0015), (WHEEL - 0.0015, 0.0015), (WHEEL, 0.003), (WHEEL, half - 0.0022)]
    profile += [(WHEEL - 0.0022, half), (0.040, half)]
    studio.part("Tyre", solids.revolve(profile, 48).moved(across), RUBBER, BLACK)
    holes = [outlines.circle(0.0085, at, 16) for at in outlines.circle(0.0245, segments=5)]
    rim = slab(outlines.circle(0.040, segments=48), -half + 0.0015, half - 0.0015, 0.0015, holes)
    rim += pin(0.012, half - 0.0015, half, chamfer=0.0005, segments=24).named("cap")
    studio.part("Rim", rim, ALUMINIUM, SILVER, rim.painted(YELLOW, "cap"))
    return {part.name: part for part in studio.parts}


def lift_parts(studio):
    """Mast, its head, carriage, gripper body, finger and pad; returned by name."""
    mast = solids.extrude(outlines.rounded_rectangle(0.026, 0.050, 0.004, segments=4), MAST).named("post")
    for name, y in (("left", 0.018), ("right", -0.018)):
        mast += solids.box(0.005, 0.007, MAST - 0.030, (0.0155, y, MAST / 2)).named(f"{name} rail")
    foot = solids.extrude(outlines.rounded_rectangle(0.060, 0.080, 0.010, segments=5), 0.006, 0.0015)
    mast += foot.moved(frame((0, 0, -0.006))).named("foot")
    studio.part("Mast", mast, ALUMINIUM, GRAPHITE, mast.painted(STEEL_GREY, "rail"))
    head = solids.extrude(outlines.rounded_rectangle(0.040, 0.062, 0.008, segments=5), 0.018, 0.003)
    studio.part("Mast head", head, ABS, YELLOW)

    plate = slab(outlines.rounded_rectangle(0.012, 0.056, 0.002, (0.0245, 0), 3), -0.031, 0.031, 0.0015)
    studio.part("Carriage", plate, ALUMINIUM, SILVER)
    body = solids.extrude(outlines.rounded_rectangle(0.034, 0.140, 0.010, segments=5), 0.030, 0.003)
    rail = solids.box(0.006, 0.126, 0.010, (0.020, 0, 0.015)).named("rail")
    colours = rail.painted(STEEL_GREY) | {"chamfer": GRAPHITE}
    studio.part("Gripper body", body + rail, ABS, WHITE, colours)
    # The left finger: its pad looks to the right, at y = 0.
    base = solids.extrude([(0, 0.002), (0.020, 0.002), (0.020, 0.030), (0, 0.030)], 0.024, 0.0015)
    outline = [(0.018, 0.004), (0.088, 0.004), (0.088, 0.009), (0.045, 0.018), (0.018, 0.022)]
    finger = base + solids.extrude(outline, 0.020, 0.0015).moved(frame((0, 0, 0.002))).named("jaw")
    studio.part("Finger", finger, ABS, GRAPHITE)
    pad = solids.box(0.034, 0.004, 0.016, (0.069, 0.002, 0.012))
    studio.part("Finger pad", pad, RUBBER, YELLOW)
    return {part.name: part for part in studio.parts}


def camera_parts(studio):
    """Yoke and camera; the camera turns about the origin, and looks along x. Returned by name."""
    ear = outlines.hull(outlines.circle(0.010, segments=24), [(-0.008, -0.024), (0.008, -0.024)])
    yoke = slab(ear, 0.0235, 0.0270, 0.0008).named("left")
    yoke += slab(ear, -0.0270, -0.0235, 0.0008).named("right")
    base = solids.extrude(outlines.rounded_rectangle(0.020, 0.054, 0.004, segments=4), 0.004, 0.001)
    studio.part("Yoke", yoke + base.moved(frame((0, 0, -0.026))).named("base"), ALUMINIUM, GRAPHITE)
    case = slab(outlines.rounded_rectangle(0.026, 0.024, 0.005, (-0.002, 0), 4), -0.0205, 0.0205, 0.002)
    case += pin(0.004, 0.0205, 0.0250).named("left pin") + pin(0.004, -0.0250, -0.0205).named("right pin")
    for name, y in (("left eye", 0.010), ("right eye", -0.010)):
        at = frame((0.011, y, 0), x=(0, 1, 0), z=(1, 0, 0))
        case += solids.tube(0.0075, 0.0058, 0.004, 0.0008, 20).moved(at).named(name)
        case += solids.cylinder(0.0056, 0.0015, 0, 20).moved(at).named(f"{name} glass")
    colours = case.painted(STEEL_GREY, "pin") | case.painted(BLACK, "eye face") | case.painted(GLASS, "glass")
    studio.part("Stereo camera", case, ABS, WHITE, colours, mass=0.06)
    return {part.name: part for part in studio.parts}
