"""Inertias that no solid can have: refused, recomputed from the link's shapes, or projected."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Literal

from linkwright.stages.formats.urdf.model import Urdf, UrdfLink, UrdfShape
from linkwright.stages.graph.urdf.solid_inertia import solid_of
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import (
    FLATTEST_WRITTEN,
    NEXT_TO_NOTHING,
    is_physical,
    no_thinner,
    principal,
    spread,
)
from linkwright.stages.robot.model.robot import Array, Inertial, frozen

Policy = Literal["refuse", "recompute", "project"]

FLATTEST = 1e-6
"""Of the largest `spread`: the smallest that a repaired inertia has."""

Solid = Callable[[Iterable[UrdfShape]], Inertial | None]


def repaired(urdf: Urdf, policy: Policy, bundle: Bundle, log: Diagnostics) -> Urdf:
    """The file with inertias that a solid can have, where `policy` allows it; W-INERTIA for
    each change. Refused inertias stay, to be reported by the check of all links, except a mass below zero
    and an inertia without mass (E-INERTIA). A link that does not move needs no mass: its inertia is left out.
    """
    moved = {joint.child for joint in urdf.joints if joint.type != "fixed"}

    def solid(shapes: Iterable[UrdfShape]) -> Inertial | None:
        return solid_of(shapes, bundle)

    links = (
        replace(link, inertial=_repaired(link, policy, solid, link.name in moved, log)) for link in urdf.links
    )
    return replace(urdf, links=tuple(links))


def _repaired(link: UrdfLink, policy: Policy, solid: Solid, moves: bool, log: Diagnostics) -> Inertial | None:
    own = link.inertial
    if own is None or (own.mass == 0 and not own.inertia.any()):
        return None
    if own.mass <= 0:
        _report_without_mass(link, own, policy == "refuse" and (moves or own.mass < 0), log)
        return None
    if is_physical(own):
        return _off_the_edge(own)
    if policy == "refuse":
        return own
    made = solid(link.visuals) or solid(link.collisions) if policy == "recompute" else None
    if made is not None:
        found = Inertial(own.mass, made.com, frozen(made.inertia * (own.mass / made.mass)))
        how = "that of a uniform solid of the link's shapes, about its centre of mass"
    else:
        found = Inertial(own.mass, own.com, nearest(own.inertia))
        how = "the nearest possible inertia"
        how = how if policy == "project" else f"{how}, since no shape of the link encloses a volume"
    text = f"{why_not(own)}; it was replaced by {how}: {_moments(found.inertia)} kg m²"
    log.report("W-INERTIA", text, link.name, "correct it in the file, or give mass: {links: {...}}")
    return found


def _report_without_mass(link: UrdfLink, own: Inertial, refused: bool, log: Diagnostics) -> None:
    what = f"its mass is {own.mass:g} kg"
    if own.mass == 0:
        what = f"it has an inertia ({_moments(own.inertia)} kg m²), but no mass"
    if refused:
        hint = "correct it in the file, or set its mass to 0: source.bad_inertia=project"
        log.report("E-INERTIA", what, link.name, hint)
    else:
        log.report(
            "W-INERTIA", f"{what}: treated as a link without mass", link.name, "correct it in the file"
        )


def nearest(inertia: Array) -> Array:
    """The inertia (3, 3) nearest to this one that a solid of some thickness has."""
    return no_thinner(inertia, max(FLATTEST * float(spread(inertia).max()), NEXT_TO_NOTHING / 2))


def _off_the_edge(own: Inertial) -> Inertial:
    """The same, but for a flat body a hair thicker, by less than any file's digits: on the edge of the
    possible engines see it beyond."""
    values = spread(own.inertia)
    floor = FLATTEST_WRITTEN * float(values.sum() - values.min())
    return own if values.min() >= floor else replace(own, inertia=no_thinner(own.inertia, floor))


def why_not(inertial: Inertial) -> str:
    """Why no solid can have an inertia, with its numbers."""
    low, *_ = principal(inertial.inertia)
    moments = f"its principal moments are {_moments(inertial.inertia)} kg m²"
    if low <= 0:
        return f"{moments}: not all are above zero"
    return f"{moments}: the largest is more than the other two together"


def _moments(inertia: Array) -> str:
    return ", ".join(f"{moment:.4g}" for moment in principal(inertia))
