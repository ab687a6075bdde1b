"""Finds meshes whose size does not fit the robot: a mixed-up unit is off by a thousand."""

from collections.abc import Iterator, Sequence

from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.bare.figures import ShapeFigures, WeighedBody, reach
from linkwright.stages.validate.bare.findings import CodedFinding

MAX_REACHES = 30.0
"""A mesh is taken to be in millimetres if it is at least this many times as large as the robot's reach."""

MIN_SIZE = 2.0
"""A mesh that is smaller than this [m] is never taken to be in millimetres."""

_MIN_REACH = 1e-3
"""Reach [m] below which a robot's size says nothing about its meshes."""


def check(bodies: Sequence[WeighedBody]) -> Iterator[CodedFinding]:
    """Yields a single finding for each mesh that is probably in millimetres, even if several shapes use
    it."""
    robot_reach = reach(bodies)
    reported: set[str] = set()
    for body in bodies:
        for shape in body.shapes:
            if _is_huge(shape, robot_reach) and shape.element not in reported:
                reported.add(shape.element)
                message = f'{shape.extent:.3g} m wide, on "{body.name}" of a robot whose joints span '
                message += f"{robot_reach:.2g} m: is it in millimetres? (scale 0.001 0.001 0.001)"
                yield "C-UNITS", Finding(shape.element, shape.attribute, message)


def _is_huge(shape: ShapeFigures, robot_reach: float) -> bool:
    min_extent = max(MAX_REACHES * robot_reach, MIN_SIZE)
    return shape.mesh and robot_reach >= _MIN_REACH and shape.extent >= min_extent
