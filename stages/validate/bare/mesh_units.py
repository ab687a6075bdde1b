"""Finds meshes whose size does not fit the robot: a mixed-up unit is off by a thousand."""

from collections.abc import Iterator, Sequence

from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.bare.figures import BareBody, ShapeFigures, origin_span
from linkwright.stages.validate.bare.findings import CodedFinding

MIN_SPANS = 30.0
"""A mesh is taken to be in millimetres if it is at least this many times as wide as the robot's joints span
(`origin_span`)."""

MIN_EXTENT = 2.0
"""Size [m] below which a mesh is never taken to be in millimetres."""

_MIN_SPAN = 1e-3
"""Span [m] of the joints below which it says nothing about the size of the meshes."""


def check(bodies: Sequence[BareBody]) -> Iterator[CodedFinding]:
    """Yields one finding for each mesh that is probably in millimetres, even if several shapes use it."""
    robot_span = origin_span(bodies)
    reported: set[str] = set()
    for body in bodies:
        for shape in body.shapes:
            if _is_huge(shape, robot_span) and shape.element not in reported:
                reported.add(shape.element)
                message = f'{shape.extent:.3g} m wide, on "{body.name}" of a robot whose joints span '
                message += f"{robot_span:.2g} m: is it in millimetres? (scale 0.001 0.001 0.001)"
                yield "C-UNITS", Finding(shape.element, shape.attribute, message)


def _is_huge(shape: ShapeFigures, robot_span: float) -> bool:
    """Tells whether a shape is a mesh that is too large for a robot whose joints span `robot_span` [m]."""
    min_extent = max(MIN_SPANS * robot_span, MIN_EXTENT)
    return shape.mesh and robot_span >= _MIN_SPAN and shape.extent >= min_extent
