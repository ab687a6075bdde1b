"""Configuration of the graph stage: masses."""

from dataclasses import replace
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from linkwright.stages.robot.quantity_keys import Position
from linkwright.stages.robot.section import NonNegative, Number, Positive, Section, Text, example, invalid


def _require_physical_inertia(values: tuple[float, ...]) -> tuple[float, ...]:
    """Returns the values; raises an error of validation unless a solid can have this inertia."""
    # Imported late, since this loads numpy, and most configurations set no inertia.
    from linkwright.stages.robot.dynamics.inertia import TINY_INERTIAL, is_physical, tensor

    if len(values) not in (3, 6):
        raise invalid("must be [ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz]")
    # The mass does not matter here.
    if not is_physical(replace(TINY_INERTIAL, mass=1.0, inertia=tensor(values))):
        raise invalid("must be the inertia of a solid: positive moments, none above the sum of the other two")
    return values


Inertia = Annotated[tuple[Number, ...], AfterValidator(_require_physical_inertia)]
"""[ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz] [kg m²], products with true signs (−∫xy dm)."""


class PartMassSection(Section):
    """Mass properties of the parts that a glob matches. Values that are missing or null are those of CAD."""

    mass: Annotated[NonNegative | None, example(0.12)] = None
    """Mass [kg]; the inertia is scaled with it. 0: the part has no mass and no inertia."""

    density: Annotated[Positive | None, example(1100)] = None
    """Density [kg/m³], in place of the mass: the mass is the density times the volume."""

    com: Annotated[Position | None, example([0, 0, 0.01])] = None
    """Centre of mass in the part's own frame [m]."""

    inertia: Annotated[Inertia | None, example([1e-4, 1e-4, 1e-4])] = None
    """Inertia about the centre of mass in the axes of the part's own frame [kg m²]: ixx, iyy, izz, or these
    and ixy, ixz, iyz."""

    @model_validator(mode="after")
    def _require_single_mass(self) -> Self:
        if self.mass is not None and self.density is not None:
            raise invalid("must have a mass or a density, not both")
        return self


class LinkMassSection(Section):
    """Mass properties of the links that a glob matches. Values that are missing or null follow from the
    parts."""

    mass: Annotated[Positive | None, example(0.2)] = None
    """Mass [kg]; the inertia is scaled with it."""

    com: Annotated[Position | None, example([0, 0, 0.01])] = None
    """Centre of mass in the link's frame [m]."""

    inertia: Annotated[Inertia | None, example([1e-4, 1e-4, 1e-4])] = None
    """Inertia about the centre of mass in the axes of the link's frame [kg m²]: ixx, iyy, izz, or these and
    ixy, ixz, iyz."""


class MassSection(Section):
    """Masses of parts and links."""

    missing: Literal["auto", "error", "density", "ignore"] = "auto"
    """Parts without a mass. auto: small parts (each below 1 % of the robot's volume, together below 10 %) get
    the mass of their volume times `mass.density`, other parts are an error; error: all are an error; density:
    all get the mass of their volume; ignore: they have no mass."""

    density: Positive = 1200
    """Density for parts without a mass [kg/m³]."""

    total: Annotated[Positive | None, example(3.31)] = None
    """Mass of the whole robot [kg], as weighed: the estimated masses and their inertias are scaled to reach
    it; masses from CAD, `parts` and `links` stay. null: the estimates stay."""

    parts: Annotated[dict[Text, PartMassSection], example({"Foot*": {"density": 1100}})] = Field(
        default_factory=dict
    )
    """Glob on names and titles of parts → mass properties; later entries win, value by value."""

    links: Annotated[dict[Text, LinkMassSection], example({"palm": {"mass": 0.2}})] = Field(
        default_factory=dict
    )
    """Glob on link names → mass properties; later entries win, value by value."""
