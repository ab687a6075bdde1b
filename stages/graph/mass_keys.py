"""What the graph stage is told about masses."""

from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from stages.robot.keys import Keys, NonNegative, Number, Positive, Text, Triple

if TYPE_CHECKING:
    from stages.robot.model import Array


def tensor(values: tuple[float, ...]) -> "Array":
    """The symmetric (3, 3) tensor of [ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz]."""
    from stages.robot.model import frozen

    xx, yy, zz, xy, xz, yz = (*values, 0.0, 0.0, 0.0)[:6]
    return frozen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _of_a_solid(values: tuple[float, ...]) -> tuple[float, ...]:
    from stages.robot.inertia import is_physical
    from stages.robot.model import Inertial, frozen

    if len(values) not in (3, 6):
        text = "must be [ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz]"
        raise PydanticCustomError("inertia", text)
    if not is_physical(Inertial(1.0, frozen([0.0, 0.0, 0.0]), tensor(values))):
        text = "must be what a solid can have: positive moments, none above the sum of the other two"
        raise PydanticCustomError("inertia", text)
    return values


def refused(text: str) -> PydanticCustomError:
    """What to raise where values do not go together."""
    return PydanticCustomError("together", "{text}", {"text": text})


Inertia = Annotated[tuple[Number, ...], AfterValidator(_of_a_solid)]
"""[ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz] [kg m²], products with true signs (−∫xy dm)."""


class PartMassKeys(Keys):
    """Mass properties of the parts that a glob matches; what is left out or null stays as it is."""

    mass: NonNegative | None = None
    """Mass [kg]; the inertia grows with it. 0: it weighs nothing."""

    density: Positive | None = None
    """Density [kg/m³]: the mass is that times the volume."""

    com: Triple | None = None
    """Centre of mass [m] in the part's own frame."""

    inertia: Inertia | None = None
    """Inertia about the centre of mass in the axes of the part's own frame [kg m²]."""

    @model_validator(mode="after")
    def _one_mass(self) -> Self:
        if self.mass is not None and self.density is not None:
            raise refused("must have a mass or a density, not both")
        return self


class LinkMassKeys(Keys):
    """Mass properties of the links that a glob matches; what is left out or null is the sum of parts."""

    mass: Positive | None = None
    """Mass [kg]; the inertia grows with it."""

    com: Triple | None = None
    """Centre of mass [m] in the link's frame."""

    inertia: Inertia | None = None
    """Inertia about the centre of mass in the axes of the link's frame [kg m²]."""


class MassKeys(Keys):
    """What is done about parts without mass."""

    missing: Literal["auto", "error", "density", "ignore"] = "auto"
    """auto: parts that are small (below 1 % of the robot's volume each, and 10 % together) are
    estimated, others are errors; error: all are; density: all are estimated; ignore: they weigh
    nothing."""

    density: Positive = 1200
    """Density of estimated parts [kg/m³]."""

    parts: dict[Text, PartMassKeys] = Field(default_factory=dict)
    """Glob on names and titles of parts → mass properties; later entries win, value by value."""

    links: dict[Text, LinkMassKeys] = Field(default_factory=dict)
    """Glob on names of links → mass properties; later entries win, value by value."""
