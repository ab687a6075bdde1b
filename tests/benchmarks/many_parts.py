"""A robot of many parts to measure with: parts fastened to links, links on hinges."""

import math

import numpy as np

from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame, turn

PARTS, STUDIOS, LINKS = 120, 8, 30
TRIANGLES = 600
"""The number of triangles of each part, about."""

_SEGMENTS = TRIANGLES // 8
_HINGE = turn((1, 0, 0), math.pi / 2)


def many_parts(parts=PARTS, studios=STUDIOS, links=LINKS):
    """A fixed base and legs of hinges `dof_<n>`, each link of some chamfered discs fastened together.

    Part studios hold parts of all over the robot. Any two parts differ.
    """
    document = Document("Many parts")
    homes = [document.studio(f"Studio {number}") for number in range(studios)]
    root = document.assembly("Robot")
    on_link = [[] for _ in range(links)]
    for number in range(parts):
        radius = 0.02 + 0.0001 * number
        disc = solids.cylinder(radius, 0.01, chamfer=0.001, segments=_SEGMENTS)
        shade = (number * 2) % 256
        part = homes[number % studios].part(f"Disc {number}", disc, density=2700, colour=(shade, 128, 200))
        of_link = on_link[number * links // parts]
        occurrence = root.add(part, fixed=number == 0)
        if of_link:
            top = frame((0, 0, 0.01))
            root.fasten(f"Weld {number}", (occurrence, np.eye(4)), (of_link[-1], top))
        of_link.append(occurrence)
    for number in range(1, links):
        parent = on_link[(number - 1) // 2]
        side = frame((0.03, 0, 0.005)) @ _HINGE
        root.revolute(
            f"dof_{number}", (on_link[number][0], _HINGE), (parent[0], side), value=0.01, limits=(-1.5, 1.5)
        )
    return document
