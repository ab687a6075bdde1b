"""Small documents with something to set: configurations, typed limits, variables."""

import numpy as np

from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.settings import Choice, Size, Switch, Words, text_of

LEG = Size("leg_length", "Leg length", "200 mm", 50, 900)
GRIPPER = Choice("List_g", "Gripper", {"_narrow": "narrow", "Wide_1": "wide grip"})
MIRRORED = Switch("mirrored", "Mirrored")
LABEL = Words("label", "Label", "none")
JAW = Choice("jaw", "Jaw", {"S": "small", "L": "large"})

METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}


def length(text):
    """A length [m] typed as "200 mm"."""
    number, unit = text.split()
    return float(number) * METRES[unit]


UPRIGHT = np.eye(4)
ACROSS = frame(x=(1, 0, 0), z=(0, 1, 0))
"""Axes of the leg's hinge: upright it turns the leg, across it the leg leans."""


def stand(leg="200 mm", gripper="_narrow", hinge=UPRIGHT):
    """A base, a leg of some length and a jaw, which is a part of a configured studio."""
    document = Document("Stand")
    parts, legs, tools = (document.studio(name) for name in ("Parts", "Legs", "Tools"))
    legs.configure([LEG], _leg)
    tools.configure([JAW], _jaw)
    size = {"_narrow": "default", "Wide_1": text_of({"jaw": "L"})}[gripper]
    root = document.assembly("Stand")
    tall = length(leg)
    base = root.add(parts.part("Base", solids.box(0.2, 0.2, 0.02), density=1000), fixed=True)
    leg_part = root.add(legs.at("default" if leg == LEG.default else text_of({LEG.id: leg})).parts[0])
    jaw = root.add(tools.at(size).parts[0])
    root.revolute("Swing", (leg_part, hinge), (base, hinge), 0.1, (-1, 1))
    root.slider("Grip", (jaw, np.eye(4)), (leg_part, frame((0, 0, tall))), 0.0, (0, 0.02))
    return document


def configured_stand():
    """The stand, whose root has a configuration of four parameters."""
    document = stand()
    parameters = [LEG, GRIPPER, MIRRORED, LABEL]
    document.configure(parameters, lambda values: stand(values["leg_length"], values["List_g"]))
    return document


def leaning_stand():
    """The stand with a leg that leans, whose root has a configuration for the leg's length."""
    document = stand(hinge=ACROSS)
    document.configure([LEG], lambda values: stand(values["leg_length"], hinge=ACROSS))
    return document


def _leg(studio, values):
    tall = length(values[LEG.id])
    studio.part("Leg", solids.box(0.03, 0.03, tall, (0, 0, tall / 2)), density=1000)


def _jaw(studio, values):
    edge = {"S": 0.02, "L": 0.05}[values["jaw"]]
    studio.part("Jaw", solids.box(edge, edge, 0.01), density=1000)


def typed_arm(low="-#Reach", high="2 * #Reach + 15 deg", stop="1/2 in", inner=("-#Reach", None)):
    """A base, an arm on a hinge, a slider on it, and a hand with a hinge of its own: limits as typed."""
    document = Document("Typed arm")
    studio = document.studio("Parts")
    part = {
        name: studio.part(name, solids.box(0.02, 0.03, 0.1), density=1000)
        for name in ("Base", "Arm", "Slide", "Palm", "Finger")
    }
    document.variable_studio("Variables", {"Reach": ("ANGLE", "30 deg")})
    root, hand = document.assembly("Arm"), document.assembly("Hand")
    document.root = root
    palm, finger = hand.add(part["Palm"]), hand.add(part["Finger"])
    reach = np.radians(30)
    hand.revolute("Curl", (finger, np.eye(4)), (palm, frame((0, 0, 0.1))), 0.1, (-reach, None), typed=inner)
    base, arm, slide = root.add(part["Base"], fixed=True), root.add(part["Arm"]), root.add(part["Slide"])
    grip = root.add(hand)
    bounds = (-reach, 2 * reach + np.radians(15))
    root.revolute("Turn", (arm, np.eye(4)), (base, frame((0, 0, 0.1))), 0.2, bounds, typed=(low, high))
    root.slider("Push", (slide, np.eye(4)), (arm, frame((0, 0, 0.1))), 0.0, (0, 0.0127), typed=("0", stop))
    root.fasten("Hand", (grip / palm, np.eye(4)), (slide, frame((0, 0, 0.1))))
    return document


def driven_stand():
    """A stand whose leg is as long as its variable says, and nothing else depends on the others."""
    document = stand()
    table = {"LegLength": ("LENGTH", "200 mm"), "Spare": ("NUMBER", "3"), "Tilt": ("ANGLE", "#Other")}
    document.variable_studio("Sizes", table)
    document.variable_studio("Other", {"Other": ("ANGLE", "10 deg")})
    document.driven = _drive
    return document


def _drive(document, values):
    tall = length(values["LegLength"])
    document.part("Leg").solid = solids.box(0.03, 0.03, tall, (0, 0, tall / 2))
