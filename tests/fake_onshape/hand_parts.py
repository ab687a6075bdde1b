"""The parts of the hand, each in a natural frame of its own. Metres; colours 0..255.

The hand points up (z), its palm looks ahead (x), and its thumb is on the left (+y). Parts of fingers lie in
the x–z plane with their hinge at the origin; a positive turn about y curls them.
"""

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.frames import frame
from tests.fake_onshape.sample_parts import pin, slab

ALUMINIUM, ABS, RUBBER = 2700.0, 1040.0, 1150.0  # kg/m³

WHITE, GRAPHITE, TEAL = (238, 238, 234), (52, 56, 62), (18, 150, 140)
SILVER = (189, 193, 198)

PROXIMAL, MIDDLE, DISTAL = 0.042, 0.027, 0.022
"""Lengths of a finger's parts, from hinge to hinge, and to the tip [m]."""

THUMB = 0.040
"""Length of the thumb's first part [m]."""

FINGERS = {
    "Index": (0.0345, 0.094),
    "Middle": (0.0115, 0.100),
    "Ring": (-0.0115, 0.096),
    "Little": (-0.0345, 0.086),
}
"""Where the knuckles are on the palm: y and z [m]."""

THUMB_AT = (0.006, 0.046, 0.013)
"""Where the thumb's base turns on the palm [m]."""

THUMB_ROOT = (-0.026, 0.0, 0.012)
"""Where the thumb's first hinge is on its base [m]."""

EAR, GAP, SIDE = 0.0062, 0.0036, 0.0078
"""Radius of the ears of a hinge; from where to where they are on either side of its middle [m]."""


def _ears(outline, at):
    """The outline on either side of a hinge, with the caps of its pin at (x, z)."""
    ears = slab(outline, GAP, SIDE, 0.0006).named("left ear")
    ears += slab(outline, -SIDE, -GAP, 0.0006).named("right ear")
    for name, (start, end) in {"left": (SIDE, SIDE + 0.0006), "right": (-SIDE - 0.0006, -SIDE)}.items():
        ears += pin(0.0034, start, end, at, segments=16).named(f"{name} cap")
    return ears


def _tongue(height):
    """The part between the ears of the hinge at the origin, up to a height."""
    foot = [(-0.0050, height), (0.0050, height)]
    outline = outlines.hull(outlines.circle(EAR - 0.0006, segments=20), foot)
    return slab(outline, -0.0031, 0.0031).named("tongue")


def _phalanx(length):
    """A finger's part: a tongue about its own hinge, and ears about the next one."""
    shell = outlines.rounded_rectangle(0.0150, length - 0.0170, 0.0035, (0, (length + 0.002) / 2), 5)
    foot = [(-0.0060, length - 0.010), (0.0060, length - 0.010)]
    ear = outlines.hull(outlines.circle(EAR, (0, length), 20), foot)
    return slab(shell, -0.0085, 0.0085, 0.0015) + _tongue(0.0115) + _ears(ear, (0, length))


def _hinges(part):
    """Colours of a part's hinges: dark, and the caps of their pins of steel."""
    return part.painted(GRAPHITE, "ear", "tongue", "socket") | part.painted(SILVER, "cap")


def arm_parts(studio):
    """Flange, forearm and cuff, on which the hand stands; returned by name."""
    screws = [outlines.circle(0.0027, at, 12) for at in outlines.circle(0.043, segments=6)]
    flange = solids.extrude(outlines.circle(0.052, segments=48), 0.008, 0.0015, screws)
    studio.part("Flange", flange, ALUMINIUM, GRAPHITE, {"chamfer": SILVER})
    profile = [(0, 0), (0.033, 0), (0.0345, 0.002), (0.0335, 0.030), (0.0325, 0.031), (0.0325, 0.034)]
    profile += [(0.0332, 0.035), (0.0300, 0.072), (0.0280, 0.075), (0, 0.075)]
    band = {f"face {number}": TEAL for number in (3, 4, 5)}
    studio.part("Forearm", solids.revolve(profile, 40), ABS, WHITE, band, mass=0.260)
    cuff = [
        (0, 0),
        (0.024, 0),
        (0.025, 0.001),
        (0.025, 0.004),
        (0.0225, 0.006),
        (0.0225, 0.009),
        (0.025, 0.011),
    ]
    cuff += [(0.025, 0.014), (0.024, 0.015), (0, 0.015)]
    studio.part("Wrist", solids.revolve(cuff, 36), ALUMINIUM, GRAPHITE, {"face 5": SILVER})
    return {part.name: part for part in studio.parts}


def palm_parts(studio):
    """Palm and its pad; returned by name."""
    corners = [outlines.circle(0.0105, (y, z - 0.021), 24) for y, z in FINGERS.values()]
    wrist = [outlines.circle(0.010, (y, 0.010), 24) for y in (-0.020, 0.022)]
    ahead = frame((-0.013, 0, 0))
    ahead[:3, :3] = [[0, 0, 1], [1, 0, 0], [0, 1, 0]]  # drawn in y and z, along x
    palm = solids.extrude(outlines.hull(*corners, *wrist), 0.026, 0.003).moved(ahead)
    for name, (y, z) in FINGERS.items():
        base = [(-0.0085, z - 0.0165), (0.0085, z - 0.0165)]
        ear = outlines.hull(outlines.circle(EAR, (0, z), 20), base)
        palm += _ears(ear, (0, z)).moved(frame((0, y, 0))).named(name)
    x, y, z = THUMB_AT
    socket = outlines.hull(outlines.circle(0.0110, (x, y), 24), [(-0.011, 0.020), (0.011, 0.020)])
    palm += solids.extrude(socket, 0.006, 0.001).moved(frame((0, 0, z - 0.006))).named("socket")
    studio.part("Palm", palm, ABS, WHITE, _hinges(palm))
    corners = [outlines.circle(0.0060, (y, z - 0.026), 16) for y, z in FINGERS.values()]
    wrist = [outlines.circle(0.006, (y, 0.018), 16) for y in (-0.016, 0.016)]
    pad = solids.extrude(outlines.hull(*corners, *wrist), 0.003, 0.0012).moved(ahead)
    studio.part("Palm pad", pad.moved(frame((0.026, 0, 0))), RUBBER, TEAL)
    return {part.name: part for part in studio.parts}


def finger_parts(studio):
    """Proximal, middle and distal part, fingertip, and the thumb's base and first part; returned by name."""
    for name, length in (("Proximal", PROXIMAL), ("Middle", MIDDLE), ("Thumb proximal", THUMB)):
        part = _phalanx(length)
        studio.part(name, part, ABS, WHITE, _hinges(part))
    tip = outlines.hull(
        outlines.circle(0.0055, (0, DISTAL - 0.0055), 24), outlines.circle(0.0035, (0, 0.0110), 16)
    )
    tip = outlines.hull(tip, [(-0.0065, 0.0085), (0.0065, 0.0085)])
    distal = slab(tip, -0.0075, 0.0075, 0.0015) + _tongue(0.0105)
    studio.part("Distal", distal, ABS, WHITE, _hinges(distal))
    ahead = frame((0.0058, 0, 0.0150), x=(0, 1, 0), z=(1, 0, 0))
    pad = solids.extrude(outlines.rounded_rectangle(0.0120, 0.0110, 0.0035, segments=5), 0.0030, 0.0010)
    studio.part("Fingertip", pad.moved(ahead), RUBBER, TEAL)

    x, _, z = THUMB_ROOT
    arm = outlines.hull(outlines.circle(0.0072, (-0.001, 0.0085), 20), outlines.circle(EAR, (x, z), 20))
    base = solids.cylinder(0.0098, 0.0180, 0.0012, 28) + _ears(arm, (x, z))
    studio.part("Thumb base", base, ABS, GRAPHITE, base.painted(SILVER, "cap"))
    return {part.name: part for part in studio.parts}
