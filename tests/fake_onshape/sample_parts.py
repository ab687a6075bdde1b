"""The parts of the desk arm, each in a natural frame of its own. Metres; colours 0..255.

Arm parts lie in the x–z plane with their pivots at or above the origin; y is across the arm.
"""

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.frames import frame

ALUMINIUM, STEEL, BRASS, ABS, RUBBER = 2700.0, 7850.0, 8500.0, 1040.0, 1150.0  # kg/m³

WHITE, GRAPHITE, ORANGE = (238, 236, 230), (52, 56, 62), (244, 111, 33)
SILVER, STEEL_GREY, GOLD, BLACK = (189, 193, 198), (148, 153, 158), (201, 164, 88), (28, 29, 31)
LENS = (38, 66, 120)

UPPER_ARM, FOREARM = 0.180, 0.160
SHOULDER = (0.0, 0.0, 0.064)  # on the turret
ROD = (-0.030, 0.0, 0.018)  # from the shoulder to the rod's pivot; the same on the elbow plate
ELBOW = (0.042, 0.0, 0.024)  # on the elbow plate
COLUMN = 0.118
PIVOT = (0.0155, 0.0, 0.046)  # of a finger on the palm; also the gears' radius
TEETH = 16


def slab(outline, start, end, chamfer=0.0, holes=()):
    """An outline in (x, z), drawn across the arm from y = `start` to y = `end`."""
    upright = frame((0, end, 0))
    upright[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    return solids.extrude(outline, end - start, chamfer, holes).moved(upright)


def pin(radius, start, end, at=(0.0, 0.0), chamfer=0.0, segments=20):
    """A cylinder across the arm at (x, z)."""
    return slab(outlines.circle(radius, at, segments), start, end, chamfer)


def _lug(radius, at=(0.0, 0.0)):
    return outlines.circle(radius, at, 32)


def _bore(radius, at=(0.0, 0.0)):
    return outlines.circle(radius, at, 20)


def base_parts(studio):
    """Base plate, foot, column sleeve, lift column and turntable; returned by name."""
    screws = [_bore(0.003, (x, y)) for x in (-0.078, 0.078) for y in (-0.045, 0.045)]
    plate = solids.extrude(outlines.rounded_rectangle(0.190, 0.150, 0.034), 0.012, 0.0025, screws)
    studio.part("Base plate", plate, ALUMINIUM, GRAPHITE, {"chamfer": SILVER})
    studio.part("Foot", solids.cylinder(0.011, 0.006, 0.0015, 24), RUBBER, BLACK)
    profile = [(0.0275, 0), (0.047, 0), (0.047, 0.005), (0.0385, 0.011), (0.0365, 0.014)]
    profile += [(0.0365, 0.090), (0.0355, 0.0915), (0.0355, 0.0955), (0.0365, 0.097), (0.0365, 0.099)]
    profile += [(0.0345, 0.101), (0.0275, 0.101)]
    band = {"face 6": ORANGE}
    studio.part("Column sleeve", solids.revolve(profile, 40), ALUMINIUM, WHITE, band)
    studio.part("Lift column", solids.tube(0.027, 0.0225, COLUMN, 0.001, 40), STEEL, STEEL_GREY)
    bearing = [(0, 0), (0.041, 0), (0.041, 0.004), (0.0395, 0.0045), (0.0395, 0.0075), (0.041, 0.008)]
    bearing += [(0.041, 0.011), (0.040, 0.012), (0, 0.012)]
    studio.part("Turntable", solids.revolve(bearing, 40), ALUMINIUM, SILVER, {"face 3": GRAPHITE})
    return {part.name: part for part in studio.parts}


def arm_parts(studio):
    """Turret, upper arm, rod, elbow plate, forearm, wrist and covers; returned by name."""
    a, b = (SHOULDER[0], SHOULDER[2]), (SHOULDER[0] + ROD[0], SHOULDER[2] + ROD[2])
    foot = [(-0.041, 0.010), (0.036, 0.010)]
    cheek = outlines.hull(_lug(0.021, a), _lug(0.013, b), foot)
    turret = solids.cylinder(0.056, 0.010, 0.0015, 48)
    turret += slab(cheek, 0.028, 0.035, 0.001).named("left")
    turret += slab(cheek, -0.035, -0.028, 0.001).named("right")
    turret += pin(0.0055, -0.028, 0.028, a).named("shaft")
    turret += pin(0.0125, 0.035, 0.0375, a, 0.001, 32).named("cap") + pin(0.008, 0.035, 0.0365, b).named(
        "stud"
    )
    caps = {"cap side": ORANGE, "cap bottom": ORANGE, "cap chamfer": ORANGE, "cap top": ORANGE}
    metal = {f"{name} {face}": STEEL_GREY for name in ("shaft", "stud") for face in ("side", "top", "bottom")}
    studio.part("Turret", turret, ABS, WHITE, caps | metal)

    top = (0.0, UPPER_ARM)
    slot = outlines.stroke([(0, 0.048), (0, 0.130)], 0.0068)
    beam = outlines.hull(_lug(0.0205), _lug(0.0165, top))
    arm = slab(beam, -0.011, 0.011, 0.0025, [_bore(0.006), _bore(0.005, top), slot])
    studio.part("Upper arm", arm, ABS, WHITE, {"hole 2": ORANGE})
    trim = slab(outlines.stroke([(0, 0.048), (0, 0.130)], 0.0118), -0.0138, -0.011, 0.0008, [slot])
    studio.part("Upper arm trim", trim, ABS, ORANGE)

    rod = slab(outlines.stroke([(0, 0), top], 0.0062), 0.0195, 0.0240, 0.001)
    rod += pin(0.0050, 0.0240, 0.0280).named("lower") + pin(0.0045, 0.0180, 0.0195, top).named("upper")
    rod += pin(0.0050, 0.0240, 0.0255, top).named("cap")
    studio.part("Parallel rod", rod, STEEL, STEEL_GREY)

    d, e = (ROD[0], ROD[2]), (ELBOW[0], ELBOW[2])
    outline = outlines.hull(_lug(0.0175), _lug(0.011, d), _lug(0.0195, e))
    plate = slab(outline, 0.012, 0.018, 0.001, [_bore(0.009, e)])
    plate += pin(0.0046, -0.0125, 0.012).named("shaft") + pin(0.0105, -0.0145, -0.0125, chamfer=0.0008).named(
        "cap"
    )
    studio.part(
        "Elbow plate", plate, ALUMINIUM, GRAPHITE, {"hole 0": SILVER, "cap bottom": SILVER, "cap top": SILVER}
    )

    tip = (FOREARM, 0.0)
    beam = outlines.hull(_lug(0.0185), _lug(0.0125, tip))
    slot = outlines.stroke([(0.042, 0), (0.112, 0)], 0.0055)
    forearm = slab(beam, -0.011, 0.011, 0.0025, [_bore(0.0045, tip), slot])
    forearm += pin(0.0085, 0.011, 0.018).named("hub")
    hub = {f"hub {face}": STEEL_GREY for face in ("side", "top", "bottom")}
    studio.part("Forearm", forearm, ABS, WHITE, {"hole 1": ORANGE, **hub})
    trim = slab(outlines.stroke([(0.042, 0), (0.112, 0)], 0.0098), -0.0138, -0.011, 0.0008, [slot])
    studio.part("Forearm trim", trim, ABS, ORANGE)

    ear = outlines.hull(_lug(0.0125), [(0.028, -0.010), (0.028, 0.010)])
    wrist = slab(ear, 0.0115, 0.0155, 0.0008).named("left") + slab(ear, -0.0155, -0.0115, 0.0008).named(
        "right"
    )
    wrist += pin(0.0042, -0.0115, 0.0115).named("shaft")
    along = frame((0.028, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    barrel = [(0, 0), (0.0195, 0), (0.021, 0.0015), (0.021, 0.008), (0.0202, 0.009), (0.0202, 0.011)]
    barrel += [(0.021, 0.012), (0.021, 0.0165), (0.0195, 0.018), (0, 0.018)]
    wrist += solids.revolve(barrel, 32).moved(along).named("barrel")
    studio.part("Wrist", wrist, ALUMINIUM, GRAPHITE, {"barrel face 4": ORANGE})
    return {part.name: part for part in studio.parts}


def gripper_parts(studio):
    """Palm, camera, jaw, pad and gear; +z is where the gripper points. Returned by name."""
    px, _, pz = PIVOT
    palm = solids.cylinder(0.0205, 0.006, 0.001, 32)
    body = outlines.rounded_rectangle(0.064, 0.028, 0.009, segments=6)
    palm += solids.extrude(body, 0.020, 0.002).moved(frame((0, 0, 0.006))).named("body")
    jaw = outlines.hull(_lug(0.0105, (px, pz)), _lug(0.0105, (-px, pz)), [(-0.027, 0.026), (0.027, 0.026)])
    for side, (start, end) in {"upper": (0.0085, 0.0120), "lower": (-0.0120, -0.0085)}.items():
        palm += slab(jaw, start, end, 0.0008).named(side)
    for name, x in {"left": px, "right": -px}.items():
        palm += pin(0.0028, -0.0085, 0.0085, (x, pz), segments=16).named(f"{name} pivot")
        palm += pin(0.0045, 0.0120, 0.0130, (x, pz), segments=16).named(f"{name} cap")
    metal = [
        f"{n} {p} {f}" for n in ("left", "right") for p in ("pivot", "cap") for f in ("side", "top", "bottom")
    ]
    white = [f"body {f}" for f in ("side", "top", "bottom", "chamfer")]
    studio.part("Palm", palm, ALUMINIUM, GRAPHITE, dict.fromkeys(metal, SILVER) | dict.fromkeys(white, WHITE))

    case = solids.extrude(outlines.rounded_rectangle(0.026, 0.012, 0.003, segments=5), 0.018, 0.001)
    lens = solids.tube(0.0048, 0.0036, 0.003, 0.0005, 20).moved(frame((0, 0, 0.018))).named("barrel")
    glass = solids.cylinder(0.0035, 0.0012, 0, 20).moved(frame((0, 0, 0.018))).named("glass")
    studio.part("Camera", case + lens + glass, ABS, BLACK, {"glass face 1": LENS, "glass face 2": LENS})

    spine = [(0, 0), (0.0115, 0.021), (0.004, 0.040), (0.004, 0.066)]
    finger = slab(outlines.stroke(spine, 0.0058, 14), 0.003, 0.0075, 0.0008, [_bore(0.003)]).named("upper")
    finger += slab(outlines.stroke(spine, 0.0058, 14), -0.0075, -0.003, 0.0008, [_bore(0.003)]).named("lower")
    finger += slab(outlines.stroke(spine[2:], 0.0045), -0.003, 0.003).named("bridge")
    studio.part("Jaw", finger, ABS, GRAPHITE)
    inward = frame((-0.0018, 0, 0.0535), x=(0, 1, 0), z=(-1, 0, 0))
    pad = solids.extrude(outlines.rounded_rectangle(0.015, 0.030, 0.004, segments=6), 0.004, 0.001)
    studio.part("Finger pad", pad.moved(inward), RUBBER, ORANGE)
    wheel = slab(outlines.gear(TEETH, PIVOT[0]), -0.0028, 0.0028, 0, [_bore(0.003)])
    studio.part("Finger gear", wheel, BRASS, GOLD)
    return {part.name: part for part in studio.parts}


def servo_parts(studio):
    """A servo's case and bearing; its shaft leaves the origin along +z. Returned by name."""
    middle = (-0.010, 0.0)
    body = outlines.rounded_rectangle(0.040, 0.021, 0.004, middle, 5)
    ears = outlines.rounded_rectangle(0.054, 0.021, 0.003, middle, 5)
    holes = [_bore(0.0016, (-0.010 + sx * 0.0235, sy * 0.005)) for sx in (-1, 1) for sy in (-1, 1)]
    case = solids.extrude(body, 0.023, 0.0012).moved(frame((0, 0, -0.035))).named("lower")
    case += solids.extrude(ears, 0.003, 0, holes).moved(frame((0, 0, -0.012))).named("ears")
    case += solids.extrude(body, 0.006, 0.0008).moved(frame((0, 0, -0.009))).named("upper")
    case += (
        solids.extrude(outlines.rounded_rectangle(0.028, 0.012, 0.002, middle, 4), 0.0008)
        .moved(frame((0, 0, -0.0358)))
        .named("label")
    )
    label = {f"label {face}": ORANGE for face in ("side", "top", "bottom")}
    studio.part("Servo case", case, ABS, GRAPHITE, label, mass=0.055)
    studio.part("Servo bearing", solids.tube(0.0085, 0.0048, 0.003, 0.0006, 28), BRASS, GOLD)
    return {part.name: part for part in studio.parts}
