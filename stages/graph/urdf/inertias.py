"""Handles inertias of a URDF that no solid can have: keeps them, so that they are refused later, recomputes
them from the link's shapes, or replaces them by the nearest possible inertia."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Literal, NamedTuple

from linkwright.stages.formats.urdf.model import Urdf, UrdfLink, UrdfShape
from linkwright.stages.graph.urdf.solid_inertia import solid_of
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import (
    MIN_WRITTEN_SPREAD,
    TINY_MOMENT,
    is_physical,
    principal,
    scaled,
    spread,
    with_min_spread,
)
from linkwright.stages.robot.model.robot import Array, Inertial

Policy = Literal["refuse", "recompute", "project"]
"""What to do with an impossible inertia: the key `source.bad_inertia`."""

MIN_SPREAD = 1e-6
"""Smallest entry of the `spread` of a repaired inertia, as a share of its largest entry."""

SolidOfShapes = Callable[[Iterable[UrdfShape]], Inertial | None]
"""Returns the inertial of a uniform solid of shapes; None if they enclose no volume."""


def with_repaired_inertias(urdf: Urdf, policy: Policy, bundle: Bundle, log: Diagnostics) -> Urdf:
    """Returns the URDF with impossible inertias repaired, as far as `policy` allows; reports W-INERTIA for
    each change.

    With "refuse", an impossible inertia is kept, and the check of all links reports it. An inertial with a
    negative mass, or with an inertia but no mass, is always dropped: with "refuse" this is an error
    (E-INERTIA) if the mass is negative or the link moves.
    """
    moving = {joint.child for joint in urdf.joints if joint.type != "fixed"}

    def solid_of_shapes(shapes: Iterable[UrdfShape]) -> Inertial | None:
        return solid_of(shapes, bundle)

    links = (
        replace(link, inertial=_repaired_inertial(link, policy, solid_of_shapes, link.name in moving, log))
        for link in urdf.links
    )
    return replace(urdf, links=tuple(links))


def _repaired_inertial(
    link: UrdfLink, policy: Policy, solid_of_shapes: SolidOfShapes, is_moving: bool, log: Diagnostics
) -> Inertial | None:
    """Returns a link's inertial, repaired as far as `policy` allows; None for a link without mass."""
    inertial = link.inertial
    # A link without mass and inertia is allowed: it only connects joints.
    if inertial is None or (inertial.mass == 0 and not inertial.inertia.any()):
        return None
    if inertial.mass <= 0:
        _report_without_mass(link, inertial, policy == "refuse" and (is_moving or inertial.mass < 0), log)
        return None
    if is_physical(inertial):
        return _thickened_if_flat(inertial)
    if policy == "refuse":
        return inertial
    if policy == "project":
        repair = _projected_repair(inertial)
    else:
        repair = _recomputed_repair(link, inertial, solid_of_shapes)
    text = (
        f"{why_unphysical(inertial)}; it was replaced by {repair.description}: "
        f"{_moments(repair.inertial.inertia)} kg m²"
    )
    log.report("W-INERTIA", text, link.name, "correct it in the file, or give mass: {links: {...}}")
    return repair.inertial


class _Repair(NamedTuple):
    """A repaired inertial, and how it was found, in words for the user."""

    inertial: Inertial
    description: str


def _projected_repair(inertial: Inertial) -> _Repair:
    nearest = Inertial(inertial.mass, inertial.com, nearest_physical(inertial.inertia))
    return _Repair(nearest, "the nearest possible inertia")


def _recomputed_repair(link: UrdfLink, inertial: Inertial, solid_of_shapes: SolidOfShapes) -> _Repair:
    solid_inertial = solid_of_shapes(link.visuals) or solid_of_shapes(link.collisions)
    if solid_inertial is None:
        repair = _projected_repair(inertial)
        return repair._replace(
            description=f"{repair.description}, since no shape of the link encloses a volume"
        )
    recomputed = scaled(solid_inertial, inertial.mass)
    return _Repair(recomputed, "that of a uniform solid of the link's shapes, about its centre of mass")


def _report_without_mass(link: UrdfLink, inertial: Inertial, is_error: bool, log: Diagnostics) -> None:
    """Reports an inertial whose mass is not positive. `is_error`: whether that is an error."""
    text = f"its mass is {inertial.mass:g} kg"
    if inertial.mass == 0:
        text = f"it has an inertia ({_moments(inertial.inertia)} kg m²), but no mass"
    if is_error:
        hint = "correct it in the file, or treat the link as massless: source.bad_inertia=project"
        log.report("E-INERTIA", text, link.name, hint)
    else:
        log.report(
            "W-INERTIA", f"{text}: treated as a link without mass", link.name, "correct it in the file"
        )


def nearest_physical(inertia: Array) -> Array:
    """Returns the inertia (3, 3) nearest to this one whose smallest spread is at least the share `MIN_SPREAD`
    of its largest."""
    # TINY_MOMENT / 2 is the spread of `TINY_INERTIAL`, the inertial of a link that only connects two joints.
    return with_min_spread(inertia, max(MIN_SPREAD * float(spread(inertia).max()), TINY_MOMENT / 2))


def _thickened_if_flat(inertial: Inertial) -> Inertial:
    """Returns the inertial, with a flat body made thicker by less than the digits of a file show: engines
    reject inertias at the limit of the possible."""
    spreads = spread(inertial.inertia)
    # The largest moment is the sum of the two largest spreads.
    smallest_spread = MIN_WRITTEN_SPREAD * float(spreads.sum() - spreads.min())
    if spreads.min() >= smallest_spread:
        return inertial
    return replace(inertial, inertia=with_min_spread(inertial.inertia, smallest_spread))


def why_unphysical(inertial: Inertial) -> str:
    """Returns why no solid can have an inertia, with its numbers."""
    low, *_ = principal(inertial.inertia)
    moments = f"its principal moments are {_moments(inertial.inertia)} kg m²"
    if low <= 0:
        return f"{moments}: not all are above zero"
    return f"{moments}: the largest is more than the other two together"


def _moments(inertia: Array) -> str:
    """Returns the principal moments [kg m²] of an inertia (3, 3) as a text."""
    return ", ".join(f"{moment:.4g}" for moment in principal(inertia))
