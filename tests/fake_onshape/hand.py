"""The hand: four fingers and a thumb, each bent by one motor; gear relations curl the rest of each finger.

A finger is a sub-assembly that is used four times, with a relation of its own inside; the relation from its
knuckle to that belongs to the hand.
"""

from tests.fake_onshape import hand_parts as shapes
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame, product, turn

CURL, TIP, THUMB_TIP = 1.1, 0.7, 0.9
"""Ratios: of a finger's bend to its knuckle, of its tip to its bend, of the thumb's tip to its bend."""

BENT = {"Index": 0.16, "Middle": 0.20, "Ring": 0.24, "Little": 0.28}
"""How far the fingers are bent in the saved pose [rad]."""

KNUCKLE, THUMB_BEND = 1.35, 0.8
"""How far a knuckle and the thumb's hinge bend [rad]."""

THUMB_LEAN = 0.7
"""How far the thumb leans outwards where its hinge is at 0 [rad]."""


def bend(x=0.0, y=0.0, z=0.0):
    """A mate connector whose z is across a finger (+y): a positive turn curls what points up."""
    return frame((x, y, z), x=(1, 0, 0), z=(0, 1, 0))


def hand_document():
    """The robot: 31 parts, 15 hinges, nine of which follow by relations. Connectors at palm and thumb."""
    document = Document("Hand")
    hand = document.assembly("Hand")
    document.root = hand
    stand = shapes.arm_parts(document.studio("Arm"))
    palms = shapes.palm_parts(document.studio("Palm"))
    parts = shapes.finger_parts(document.studio("Fingers"))

    flange = hand.add(stand["Flange"], fixed=True)
    forearm, wrist, palm = (hand.add(part) for part in (stand["Forearm"], stand["Wrist"], palms["Palm"]))
    hand.fasten("Forearm on flange", (forearm, frame()), (flange, frame((0, 0, 0.008))))
    hand.fasten("Wrist on forearm", (wrist, frame()), (forearm, frame((0, 0, 0.075))))
    hand.fasten("Palm on wrist", (palm, frame()), (wrist, frame((0, 0, 0.015))))
    hand.fasten("Pad on palm", (hand.add(palms["Palm pad"]), frame()), (palm, frame()))

    finger = _finger(document, parts)
    for name, (y, z) in shapes.FINGERS.items():
        added = hand.add(finger, name=name)
        document.set_value(added, finger.bend, CURL * BENT[name])
        document.set_value(added, finger.tip, TIP * CURL * BENT[name])
        ends = (added / finger.proximal, bend()), (palm, bend(0, y, z))
        knuckle = hand.revolute(f"{name} knuckle", *ends, BENT[name], (0.0, KNUCKLE))
        hand.gear(f"{name} curl", knuckle, (added, finger.bend), CURL, reverse=True)
    _thumb(hand, parts, palm)
    hand.connector("Grasp", palm, frame((0.045, 0, 0.065), x=(0, 1, 0), z=(1, 0, 0)))
    document.truth.check()
    return document


def _finger(document, parts):
    """A finger of three parts; its mates `bend` and `tip` are coupled."""
    finger = document.assembly("Finger")
    proximal, middle, distal = (finger.add(parts[name]) for name in ("Proximal", "Middle", "Distal"))
    limits = (0.0, CURL * KNUCKLE)
    tip = bend(0, 0, shapes.PROXIMAL)
    finger.bend = finger.revolute("Bend", (middle, bend()), (proximal, tip), 0.0, limits)
    tip = bend(0, 0, shapes.MIDDLE)
    finger.tip = finger.revolute("Tip", (distal, bend()), (middle, tip), 0.0, (0.0, TIP * limits[1]))
    finger.gear("Tip curl", finger.bend, finger.tip, TIP, reverse=True)
    finger.fasten("Fingertip on", (finger.add(parts["Fingertip"]), frame()), (distal, frame()))
    finger.proximal = proximal
    return finger


def _thumb(hand, parts, palm):
    """Turns about the palm's length, and bends by two coupled hinges."""
    base = hand.add(parts["Thumb base"])
    down = frame(x=(1, 0, 0), z=(0, 0, -1))
    side = frame(shapes.THUMB_AT, x=(0, -1, 0), z=(0, 0, -1))
    hand.revolute("Thumb turn", (base, down), (palm, side), 0.45, (0.0, 1.5))
    first, last = hand.add(parts["Thumb proximal"]), hand.add(parts["Distal"], name="Thumb distal")
    root = product(turn((0, 1, 0), -THUMB_LEAN, shapes.THUMB_ROOT), bend())
    hinge = hand.revolute("Thumb bend", (first, bend()), (base, root), 0.3, (0.0, THUMB_BEND))
    tip = (last, bend()), (first, bend(0, 0, shapes.THUMB))
    follower = hand.revolute("Thumb tip", *tip, 0.3 * THUMB_TIP, (0.0, THUMB_BEND * THUMB_TIP))
    hand.gear("Thumb curl", hinge, follower, THUMB_TIP, reverse=True)
    hand.fasten("Thumb fingertip on", (hand.add(parts["Fingertip"]), frame()), (last, frame()))
