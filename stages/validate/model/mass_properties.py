"""Computes the mass properties that links must have from their CAD parts, and compares them with a file's."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from linkwright.stages.robot.model.robot import Array, Inertial, Link
from linkwright.stages.validate.findings import largest_error

TOLERANCE = 1e-9
"""Tolerance of the mass (relative), the centre of mass [m] and the inertia (relative to the tensor's largest
entry)."""

UNITS = {"mass": "relative", "centre of mass": "m", "inertia": "relative to the tensor"}
"""Quantity → the unit of its difference."""


class MassProperties(NamedTuple):
    """The mass properties of a body in some frame."""

    mass: float
    """Mass [kg]."""

    com: Array
    """Centre of mass (3,) [m]."""

    inertia: Array
    """Inertia (3, 3) [kg m²] about the centre of mass."""


def differences(
    actual: MassProperties, expected: MassProperties, inertia_allowance: float = 0.0
) -> dict[str, float]:
    """Returns the difference of each quantity, in the units of `UNITS`; infinity if a value is NaN. The
    difference of the inertia is reduced by `inertia_allowance`. Without an expected mass, the centre of mass
    has no meaning and differs by 0. Where the expected mass or inertia is 0, its difference is absolute."""
    largest_entry = float(np.abs(expected.inertia).max()) or 1.0
    tensor_error = float(np.abs(actual.inertia - expected.inertia).max()) / largest_entry
    values = {
        "mass": abs(actual.mass - expected.mass) / (expected.mass or 1.0),
        "centre of mass": float(np.linalg.norm(actual.com - expected.com)) if expected.mass else 0.0,
        "inertia": tensor_error - inertia_allowance,
    }
    return {quantity: largest_error((0.0, value)) for quantity, value in values.items()}


def expected_mass_properties(link: Link, massless_inertial: Inertial | None = None) -> MassProperties:
    """Returns the mass properties that a link must have, in its frame.

    They are the user's values, else the sum over the link's parts, else, for a link that is not in CAD, its
    own inertial. `massless_inertial`: replaces the inertial of a link without mass.
    """
    inertial: Inertial | None = link.given or (None if link.parts else link.inertial)
    if massless_inertial is not None and not link.inertial.mass > 0:
        inertial = massless_inertial
    if inertial is not None:
        return _from_inertial(inertial)
    return merge(
        [express_in_frame(_from_inertial(part.inertial), part.link_from_part) for part in link.parts]
    )


def _from_inertial(inertial: Inertial) -> MassProperties:
    return MassProperties(inertial.mass, inertial.com, inertial.inertia)


def express_in_frame(properties: MassProperties, a_from_b: Array) -> MassProperties:
    """Returns mass properties in the frame a that are given in the frame b."""
    rotation = a_from_b[:3, :3]
    com = rotation @ properties.com + a_from_b[:3, 3]
    return MassProperties(properties.mass, com, rotation @ properties.inertia @ rotation.T)


def merge(bodies: Sequence[MassProperties]) -> MassProperties:
    """Returns the mass properties of several bodies together, all in the same frame.

    Sums the second-moment matrices S = ∫ x xᵀ dm = ½ tr(I) 1 − I + m c cᵀ about the common centre of mass,
    from which I = tr(S) 1 − S, rather than merging tensors by the parallel axis theorem: the robot's own
    inertials are merged by that theorem, so an error in it would not show.
    """
    mass = sum(body.mass for body in bodies)
    if mass == 0.0:
        return MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))
    com = sum((body.mass * body.com for body in bodies), np.zeros(3)) / mass
    second_moments = np.zeros((3, 3))
    for body in bodies:
        offset = body.com - com
        second_moments += 0.5 * np.trace(body.inertia) * np.eye(3) - body.inertia
        second_moments += body.mass * np.outer(offset, offset)
    return MassProperties(mass, com, np.trace(second_moments) * np.eye(3) - second_moments)
