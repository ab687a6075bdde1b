"""A document with one studio of bars, to draw small assemblies with."""

import math

import numpy as np

from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame, turn

TOP = frame((0, 0, 0.1))
OFF = turn((0.6, 0.0, 0.8), 0.7, (0.1, -0.2, 0.05))
ON = turn((0.0, 0.6, 0.8), -1.1, (-0.05, 0.1, 0.2))
SIDE = turn((0, 1, 0), math.pi / 2, (0.05, 0, 0))


class Kit:
    """A document with one studio of bars, to draw with."""

    def __init__(self):
        self.document = Document("Kit")
        self.studio = self.document.studio("Parts")
        self.root = self.document.assembly("Robot")

    def bar(self, name, size=(0.02, 0.03, 0.1), density=1000):
        return self.studio.part(name, solids.box(*size), density=density)

    def place(self, name, assembly=None, **more):
        return (assembly or self.root).add(self.bar(name), **more)

    def based(self, *names):
        """A base that is fixed, and further bars."""
        return (self.place("Base", fixed=True), *map(self.place, names))

    def elbow(self, **mate):
        """A base that is fixed, with an arm on a hinge."""
        base, arm = self.based("Arm")
        self.root.revolute("Elbow", (arm, TOP), (base, SIDE), **mate)
        return base, arm


def four_bar(kit, limits=False, value=0.5):
    """A parallelogram of four hinges about z, saved at `value` [rad], closed by its rocker's far end."""
    bounds = (-1.0, 1.0) if limits else (None, None)
    base, crank, rocker, coupler = (kit.place(n) for n in ("Base", "Crank", "Rocker", "Coupler"))
    kit.root.instances[0].fixed = True
    far = frame((0.1, 0, 0))
    kit.root.revolute("Drive", (crank, np.eye(4)), (base, np.eye(4)), value=value, limits=(-1, 1))
    kit.root.revolute("Pin", (coupler, np.eye(4)), (crank, far), value=-value, limits=bounds)
    kit.root.revolute("Swing", (rocker, np.eye(4)), (base, far), value=value, limits=bounds)
    kit.root.revolute("Close", (coupler, far), (rocker, far), closing=True, limits=bounds)


def hinged(kit, value=0.3):
    """A fixed base, and an arm that turns on it within 1 rad either way."""
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=value, limits=(-1, 1))


def two_arms(kit):
    """A fixed base with two equal arms, each held at its top; gives the base."""
    base, left, right = kit.place("Base", fixed=True), kit.place("Left"), kit.place("Right")
    kit.root.revolute("One", (left, TOP), (base, SIDE), value=0.3, limits=(-1, 1))
    kit.root.revolute("Two", (right, TOP), (base, TOP), value=-0.2, limits=(-1, 1))
    return base
