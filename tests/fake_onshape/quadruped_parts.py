"""The parts of the quadruped, each in a natural frame of its own. Metres; colours 0..255.

Leg parts lie in the x–z plane about y = 0, with the upper pivot at the origin, so that a left and a right leg
have the same ones.
"""

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.frames import frame
from tests.fake_onshape.sample_parts import (
    ABS,
    ALUMINIUM,
    BLACK,
    GRAPHITE,
    LENS,
    ORANGE,
    RUBBER,
    SILVER,
    WHITE,
    pin,
    slab,
)

THIGH, SHANK = 0.13, 0.13
FOOT = 0.016
"""The radius of a foot [m]."""

CENTRE = 0.0185  # of the trunk's section above the axes of its servos
HALF_LENGTH = 0.089  # of the trunk's shell
DEPTH = 0.046  # of a servo's case, along its axis


def _ring(width, height, radius, wall):
    outer = outlines.rounded_rectangle(width, height, radius)
    return outer, [outlines.rounded_rectangle(width - 2 * wall, height - 2 * wall, radius - wall)]


def trunk_parts(studio, hips):
    """Shell, trims, bulkhead, battery, computer, IMU, head, handle; returned by name. x is along the robot.

    `hips`: how far the axes of the legs are from the middle [m].
    """
    ahead = frame(x=(0, 1, 0), z=(1, 0, 0))
    outer, hole = _ring(0.140, 0.080, 0.016, 0.0025)
    along = frame((-HALF_LENGTH, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    studio.part("Trunk", solids.extrude(outer, 2 * HALF_LENGTH, 0, hole).moved(along), ABS, WHITE)
    outer, hole = _ring(0.145, 0.085, 0.0185, 0.0025)
    studio.part("Trim", solids.extrude(outer, 0.012, 0.001, hole).moved(ahead), ABS, ORANGE)
    bores = [outlines.circle(0.012, (side * hips, -CENTRE), 20) for side in (-1, 1)]
    plate = solids.extrude(outlines.rounded_rectangle(0.140, 0.080, 0.016), 0.003, 0.0008, bores).moved(ahead)
    studio.part("Bulkhead", plate, ALUMINIUM, GRAPHITE, {"chamfer": SILVER})
    block = solids.extrude(outlines.rounded_rectangle(0.075, 0.070, 0.006, segments=4), 0.030, 0.002)
    studio.part("Battery", block, ABS, GRAPHITE, {"top": ORANGE}, mass=0.38)
    board = solids.box(0.070, 0.060, 0.012)
    studio.part("Computer", board, ABS, (24, 96, 60), mass=0.08)
    studio.part("IMU module", solids.box(0.016, 0.016, 0.004), ABS, (24, 60, 120), mass=0.004)

    side = [(-0.020, 0.004), (-0.020, 0.026), (0.010, 0.034), (0.028, 0.024), (0.028, 0.004)]
    head = slab(outlines.hull(*[outlines.circle(0.004, at, 16) for at in side]), -0.034, 0.034, 0.002)
    face = frame((0.032, 0, 0.014), x=(0, 1, 0), z=(1, 0, 0))
    mask = solids.extrude(outlines.rounded_rectangle(0.058, 0.018, 0.008, segments=5), 0.002)
    head += mask.moved(face).named("mask")
    colours = dict.fromkeys(("mask side", "mask top", "mask bottom"), BLACK)
    for name, y in {"left": 0.017, "right": -0.017}.items():
        at = frame((0.034, y, 0.014), x=(0, 1, 0), z=(1, 0, 0))
        head += solids.cylinder(0.0055, 0.0015, 0.0004, 20).moved(at).named(name)
        colours |= {f"{name} face {index}": LENS for index in range(4)}
    studio.part("Head", head, ABS, WHITE, colours, mass=0.09)
    grip = outlines.stroke([(-0.055, 0), (-0.042, 0.020), (0.042, 0.020), (0.055, 0)], 0.005, 8)
    studio.part("Handle", slab(grip, -0.008, 0.008, 0.0015), ABS, GRAPHITE)
    return {part.name: part for part in studio.parts}


def leg_parts(studio):
    """Hip bracket, thigh, thigh frame, shank and foot; returned by name."""
    ahead = frame(x=(0, 1, 0), z=(1, 0, 0))
    hip = solids.cylinder(0.018, 0.003, 0.0008, 28).moved(ahead)
    back = solids.extrude(outlines.rounded_rectangle(0.048, 0.047, 0.008, segments=5), 0.003)
    hip += back.moved(frame((0.003, 0, 0), x=(0, 1, 0), z=(1, 0, 0))).named("back")
    root = outlines.rounded_rectangle(0.002, 0.048, 0.0009, (0.007, 0), 2)
    cheek = outlines.hull(root, outlines.circle(0.020, (0.057, 0), 24))
    for name, z in {"upper": 0.0205, "lower": -0.0235}.items():
        hip += solids.extrude(cheek, 0.003, 0.0008).moved(frame((0, 0, z))).named(name)
    studio.part("Hip bracket", hip, ALUMINIUM, SILVER)

    plate = outlines.hull(outlines.circle(0.0215, segments=32), outlines.circle(0.0205, (0, -THIGH), 32))
    holes = [outlines.circle(0.0115, (0, -THIGH), 20), outlines.stroke([(0, -0.035), (0, -0.060)], 0.007)]
    bones = slab(plate, 0.0235, 0.0265, 0.0008, holes).named("left")
    bones += slab(plate, -0.0265, -0.0235, 0.0008, holes).named("right")
    bones += pin(0.013, 0.0265, 0.0310, chamfer=0.001, segments=28).named("left hub")
    bones += pin(0.013, -0.0310, -0.0265, chamfer=0.001, segments=28).named("right hub")
    faces = ("side", "chamfer", "top", "bottom")
    hubs = {f"{side} hub {face}": ORANGE for side in ("left", "right") for face in faces}
    studio.part("Thigh frame", bones, ALUMINIUM, GRAPHITE, hubs)
    cover = outlines.hull(outlines.circle(0.0205, segments=32), outlines.circle(0.019, (0, -0.056), 28))
    studio.part("Thigh cover", slab(cover, -0.0235, 0.0235, 0.003), ABS, WHITE, mass=0.030)

    fork = outlines.hull(outlines.circle(0.0145, segments=28), outlines.circle(0.009, (0, -0.054), 24))
    shank = slab(fork, 0.0270, 0.0300, 0.0008).named("left")
    shank += slab(fork, -0.0300, -0.0270, 0.0008).named("right")
    end = [(-0.009, -0.066), (0.009, -0.066)]
    bridge = outlines.hull(outlines.circle(0.009, (0, -0.054), 24), end)
    shank += slab(bridge, -0.0270, 0.0270).named("bridge")
    strut = outlines.hull(end, outlines.circle(0.0065, (0, 0.014 - SHANK), 20))
    shank += slab(strut, -0.009, 0.009, 0.002).named("strut")
    studio.part("Shank", shank, ALUMINIUM, SILVER)
    studio.part("Foot", solids.ball(FOOT, 24, 12), RUBBER, BLACK)
    return {part.name: part for part in studio.parts}


def servo_part(studio):
    """A servo whose axis is z, with its middle at the origin; its body reaches towards -x."""
    body = outlines.rounded_rectangle(0.0651, 0.0402, 0.005, (0.014 - 0.0651 / 2, 0), 5)
    case = solids.extrude(body, DEPTH, 0.0015).moved(frame((0, 0, -DEPTH / 2)))
    horn = solids.cylinder(0.011, 0.004, 0.0006, 24).moved(frame((0, 0, DEPTH / 2))).named("horn")
    metal = {f"horn face {index}": SILVER for index in range(4)}
    return studio.part("MX-106", case + horn, ABS, GRAPHITE, metal, mass=0.153)
