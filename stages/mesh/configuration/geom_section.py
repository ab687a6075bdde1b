"""Configuration of `geoms`: properties of contact, by globs on link names."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Strict

from linkwright.stages.robot.quantity_keys import NonNegativeLength
from linkwright.stages.robot.section import NonNegative, Number, Section, Solref, example, invalid

Solimp = tuple[Number, Number, Number, Number, Number]


def _checked_solimp(solimp: Solimp | None) -> Solimp | None:
    if solimp is None:
        return None
    low, high, width, middle, power = solimp
    if not (0 < low <= high < 1 and width > 0 and 0 < middle < 1 and power >= 1):
        raise invalid(
            "must be [d0, dwidth, width, midpoint, power] with 0 < d0 <= dwidth < 1, width > 0, "
            "0 < midpoint < 1 and power >= 1"
        )
    return solimp


class GeomContactSection(Section):
    """MuJoCo's properties of contact; null: MuJoCo's default. Of two geoms in contact the one with the higher
    priority decides; with equal priorities MuJoCo combines them."""

    friction: Annotated[
        tuple[NonNegative, NonNegative, NonNegative] | None, example([1.2, 0.005, 0.0001])
    ] = None
    """Sliding [-], torsional [m] and rolling [m] friction."""

    condim: Annotated[Literal[1, 3, 4, 6] | None, example(4)] = None
    """Directions in which the contact acts. 1: along its normal; 3: also sliding; 4: also turning about the
    normal; 6: also rolling."""

    solref: Annotated[Solref | None, example([0.01, 1])] = None
    """[time constant, damping ratio] in s and without unit, or [-stiffness, -damping]."""

    solimp: Annotated[Solimp | None, AfterValidator(_checked_solimp), example([0.9, 0.95, 0.001, 0.5, 2])] = (
        None
    )
    """[d0, dwidth, width, midpoint, power]: impedance from d0 to dwidth over a width [m] of penetration."""

    margin: Annotated[NonNegativeLength | None, example(0.001)] = None
    """Distance at which contacts begin [m]."""

    priority: Annotated[int | None, Strict(), example(1)] = None
    """The geom with the higher priority sets the properties of a contact of two geoms."""


class GeomSection(Section):
    """Properties of the geoms of the links, or of the colliders of the parts, that a glob matches."""

    visual: GeomContactSection = GeomContactSection()
    """Properties of visual geoms, which touch nothing unless your own changes to the model let them."""

    collision: GeomContactSection = GeomContactSection()
    """Properties of colliders."""
