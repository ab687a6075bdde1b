"""A document with one studio of bars, to draw small assemblies with."""

import math

import numpy as np

from tests.fake_onshape import solids
from tests.fake_onshape.document import Assembly, Document
from tests.fake_onshape.frames import frame, turn

TOP = frame((0, 0, 0.1))
OFF = turn((0.6, 0.0, 0.8), 0.7, (0.1, -0.2, 0.05))
ON = turn((0.0, 0.6, 0.8), -1.1, (-0.05, 0.1, 0.2))
SIDE = turn((0, 1, 0), math.pi / 2, (0.05, 0, 0))


class Kit:
    """A document with one studio of bars, to draw with."""

    def __init__(self) -> None:
        self.document = Document("Kit")
        self.studio = self.document.studio("Parts")
        self.root = self.document.assembly("Robot")

    def bar(self, name: str, size: tuple[float, float, float] = (0.02, 0.03, 0.1), density: float = 1000):
        return self.studio.part(name, solids.box(*size), density=density)

    def place(self, name: str, assembly: Assembly | None = None, **more: object):
        return (assembly or self.root).add(self.bar(name), **more)


def four_bar(kit: Kit, limits: bool = False, value: float = 0.5) -> None:
    """A parallelogram of four hinges about z, saved at `value` [rad], closed by its rocker's far end."""
    bounds = (-1.0, 1.0) if limits else (None, None)
    base, crank, rocker, coupler = (kit.place(n) for n in ("Base", "Crank", "Rocker", "Coupler"))
    kit.root.instances[0].fixed = True
    far = frame((0.1, 0, 0))
    kit.root.revolute("Drive", (crank, np.eye(4)), (base, np.eye(4)), value=value, limits=(-1, 1))
    kit.root.revolute("Pin", (coupler, np.eye(4)), (crank, far), value=-value, limits=bounds)
    kit.root.revolute("Swing", (rocker, np.eye(4)), (base, far), value=value, limits=bounds)
    kit.root.revolute("Close", (coupler, far), (rocker, far), closing=True, limits=bounds)
