"""Refuses inertias that no solid can have, recomputes them from the link's shapes, or projects them."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Literal

from linkwright.stages.formats.urdf.model import Urdf, UrdfLink, UrdfShape
from linkwright.stages.graph.urdf.solid_inertia import solid_of
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import (
    MIN_WRITTEN_SPREAD,
    NEXT_TO_NOTHING,
    is_physical,
    no_thinner,
    principal,
    spread,
)
from linkwright.stages.robot.model.robot import Array, Inertial, frozen

Policy = Literal["refuse", "recompute", "project"]

MIN_SPREAD = 1e-6
"""Smallest `spread` of a repaired inertia, as a share of its largest."""

Solid = Callable[[Iterable[UrdfShape]], Inertial | None]


def with_repaired_inertias(urdf: Urdf, policy: Policy, bundle: Bundle, log: Diagnostics) -> Urdf:
    """Returns the file with inertias that a solid can have, where `policy` allows it; reports W-INERTIA for
    each change. Refused inertias stay, to be reported by the check of all links, except a mass below zero and
    an inertia without mass (E-INERTIA). A link that does not move needs no mass: its inertia is left out."""
    moved = {joint.child for joint in urdf.joints if joint.type != "fixed"}

    def solid(shapes: Iterable[UrdfShape]) -> Inertial | None:
        return solid_of(shapes, bundle)

    links = (
        replace(link, inertial=_repaired(link, policy, solid, link.name in moved, log)) for link in urdf.links
    )
    return replace(urdf, links=tuple(links))


def _repaired(
    link: UrdfLink, policy: Policy, solid: Solid, is_moving: bool, log: Diagnostics
) -> Inertial | None:
    inertial = link.inertial
    if inertial is None or (inertial.mass == 0 and not inertial.inertia.any()):
        return None
    if inertial.mass <= 0:
        _report_without_mass(link, inertial, policy == "refuse" and (is_moving or inertial.mass < 0), log)
        return None
    if is_physical(inertial):
        return _thicken(inertial)
    if policy == "refuse":
        return inertial
    uniform = solid(link.visuals) or solid(link.collisions) if policy == "recompute" else None
    if uniform is not None:
        repaired_inertial = Inertial(
            inertial.mass, uniform.com, frozen(uniform.inertia * (inertial.mass / uniform.mass))
        )
        how = "that of a uniform solid of the link's shapes, about its centre of mass"
    else:
        repaired_inertial = Inertial(inertial.mass, inertial.com, nearest_physical(inertial.inertia))
        how = "the nearest possible inertia"
        how = how if policy == "project" else f"{how}, since no shape of the link encloses a volume"
    text = (
        f"{why_unphysical(inertial)}; it was replaced by {how}: {_moments(repaired_inertial.inertia)} kg m²"
    )
    log.report("W-INERTIA", text, link.name, "correct it in the file, or give mass: {links: {...}}")
    return repaired_inertial


def _report_without_mass(link: UrdfLink, inertial: Inertial, refused: bool, log: Diagnostics) -> None:
    text = f"its mass is {inertial.mass:g} kg"
    if inertial.mass == 0:
        text = f"it has an inertia ({_moments(inertial.inertia)} kg m²), but no mass"
    if refused:
        hint = "correct it in the file, or set its mass to 0: source.bad_inertia=project"
        log.report("E-INERTIA", text, link.name, hint)
    else:
        log.report(
            "W-INERTIA", f"{text}: treated as a link without mass", link.name, "correct it in the file"
        )


def nearest_physical(inertia: Array) -> Array:
    """Returns the inertia (3, 3) nearest to this one that a solid of some thickness has."""
    return no_thinner(inertia, max(MIN_SPREAD * float(spread(inertia).max()), NEXT_TO_NOTHING / 2))


def _thicken(inertial: Inertial) -> Inertial:
    """Makes a flat body a hair thicker, by less than any file's digits: engines reject inertias on the very
    edge of the possible."""
    values = spread(inertial.inertia)
    floor = MIN_WRITTEN_SPREAD * float(values.sum() - values.min())
    return (
        inertial if values.min() >= floor else replace(inertial, inertia=no_thinner(inertial.inertia, floor))
    )


def why_unphysical(inertial: Inertial) -> str:
    """Returns why no solid can have an inertia, with its numbers."""
    low, *_ = principal(inertial.inertia)
    moments = f"its principal moments are {_moments(inertial.inertia)} kg m²"
    if low <= 0:
        return f"{moments}: not all are above zero"
    return f"{moments}: the largest is more than the other two together"


def _moments(inertia: Array) -> str:
    return ", ".join(f"{moment:.4g}" for moment in principal(inertia))
