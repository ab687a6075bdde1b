"""The value that a comparison of a collider with its part gives."""

from dataclasses import dataclass
from typing import Literal

By = Literal["boolean", "sampling"]


@dataclass(frozen=True, slots=True)
class Measures:
    """How a collider, the union of its pieces, differs from its part.

    `extra`, `missing`: volume of the collider outside the part, and of the part outside the collider, as
    shares of the part's volume; `by` what they were worked out. Protrusion [m] is the distance from the part
    of a point of the collider's outer surface, 0 where that is within the part; bareness [m] the distance
    from the collider of a point of the part's surface, 0 where that is within a piece. `max` is over all
    points; `p95` is what 95 % of the area stays within, and no area counts for less because it is within.
    """

    extra: float
    missing: float
    by: By
    protrusion_p95: float
    protrusion_max: float
    bareness_p95: float
    bareness_max: float
