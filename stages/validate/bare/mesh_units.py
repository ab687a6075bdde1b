"""Whether meshes have the size of the robot: a unit that was mixed up is off by a thousand."""

from collections.abc import Iterator, Sequence

from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.bare.figures import ShapeFigures, WeighedBody, reach
from linkwright.stages.validate.bare.findings import Coded

LARGE = 30.0
"""A mesh of this many times the robot's reach is in millimetres."""

LEAST = 2.0
"""Smaller meshes [m] may be in metres."""


def look(bodies: Sequence[WeighedBody]) -> Iterator[Coded]:
    """Meshes whose units were mixed up, each once."""
    robot = reach(bodies)
    reported: set[str] = set()
    for body in bodies:
        for shape in body.shapes:
            if _is_huge(shape, robot) and shape.element not in reported:
                reported.add(shape.element)
                message = f'{shape.extent:.3g} m wide, on "{body.name}" of a robot whose joints span '
                message += f"{robot:.2g} m: is it in millimetres? (scale 0.001 0.001 0.001)"
                yield "C-UNITS", Finding(shape.element, shape.attribute, message)


def _is_huge(shape: ShapeFigures, robot: float) -> bool:
    return shape.mesh and robot >= 1e-3 and shape.extent >= max(LARGE * robot, LEAST)
