"""Mass and inertia of links: the user's values, and whether a solid can have them."""

from collections.abc import Collection, Mapping
from dataclasses import replace

import networkx as nx

from linkwright.stages.graph.globs import entries_of
from linkwright.stages.graph.mass_section import LinkMassSection, tensor
from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import ZERO, is_physical, large_enough, principal, scaled
from linkwright.stages.robot.model.robot import Inertial, Link, Robot, frozen
from linkwright.stages.robot.text.globs import as_key, listed

_CORRECT = "correct the material or the mass override in Onshape, or give inertia in mass."
_LARGER = "check the units of the document, or FASTEN the link to a larger one"
_CORRECT_FILE = (
    "correct it in the file, give mass: {links: {...}}, or set source.bad_inertia: recompute (from the "
    "shapes) or project (to the nearest possible one)"
)


def with_given_masses(robot: Robot, wanted: Mapping[str, LinkMassSection], log: Diagnostics) -> Robot:
    """The robot with the mass properties of the key `mass.links`: later entries win, value by value.

    E-GLOB for a glob that matches no link; E-MASS where values are missing of a link without mass.
    """
    names = [{link.name} for link in robot.links]
    asked = list(wanted.values())
    links = []
    for link, entries in zip(robot.links, entries_of(names, wanted, "mass.links", "link", log), strict=True):
        values: dict[str, object] = {}
        for index in entries:
            values.update({name: value for name, value in asked[index] if value is not None})
        links.append(_given(link, LinkMassSection.model_validate(values), log) if values else link)
    return replace(robot, links=tuple(links))


def _given(link: Link, asked: LinkMassSection, log: Diagnostics) -> Link:
    if link.name == WORLD_LINK:
        return link
    mass = link.inertial.mass if asked.mass is None else asked.mass
    lacks = [name for name in ("mass", "com", "inertia") if getattr(asked, name) is None]
    if link.inertial.mass == 0 and lacks:
        text = f"the link has no mass of its own: {' and '.join(lacks)} must be given too"
        log.report("E-MASS", text, link.name, f"mass: {{links: {{{as_key(link.name)}: {{mass: ...}}}}}}")
        return link
    sum_of_parts = scaled(link.inertial, mass) if link.inertial.mass > 0 else ZERO
    given = Inertial(
        mass,
        sum_of_parts.com if asked.com is None else frozen(asked.com),
        sum_of_parts.inertia if asked.inertia is None else tensor(asked.inertia),
    )
    return replace(link, inertial=given, given=given)


def check_links(robot: Robot, log: Diagnostics, drawn: bool = True) -> None:
    """E-MASS for links that move without mass, E-INERTIA for inertias that no solid can have.

    `drawn`: whether the user corrects them in CAD, not in a file.
    """
    _check_masses(robot, log, drawn)
    # Parts of a kind share one inertial, which is looked at once.
    inertials = {id(part.inertial): part.inertial for link in robot.links for part in link.parts}
    impossible = {key for key, one in inertials.items() if one.mass > 0 and not is_physical(one)}
    _check_link_inertias(robot, impossible, log, drawn)
    _check_part_inertias(robot, impossible, log)


def _check_masses(robot: Robot, log: Diagnostics, drawn: bool) -> None:
    """E-MASS by link, unless parts are known to have no mass, which is reported already.

    Links that fixed joints hold together move as one, so one of them may be without mass.
    """
    if any(one.code == "E-MASS" for one in log.problems):
        return
    for link in _moving_without_mass(robot):
        text = "the link moves, but has no mass"
        hint = f"mass: {{links: {{{as_key(link.name)}: {{mass: ...}}}}}}"
        if link.parts and drawn:
            text = "the link has no mass: all its parts are sheets or weigh nothing"
            hint = "fasten it to a solid part, or thicken it, in Onshape"
        log.report("E-MASS", text, link.name, hint)


def _has_impossible_inertia(link: Link) -> bool:
    return link.inertial.mass > 0 and not is_physical(link.inertial)


def _check_link_inertias(robot: Robot, impossible: Collection[int], log: Diagnostics, drawn: bool) -> None:
    """E-INERTIA for each link. `impossible`: ids of the inertials of parts that no solid can have."""
    for link in filter(_has_impossible_inertia, robot.links):
        moments = ", ".join(f"{moment:.4g}" for moment in principal(link.inertial.inertia))
        text = f"no solid can have the inertia of the link {link.name!r}: its principal moments are "
        culprits = [part.name for part in link.parts if id(part.inertial) in impossible]
        hint = f"{_CORRECT}{'parts' if culprits else 'links'}" if drawn else _CORRECT_FILE
        log.report("E-INERTIA", f"{text}{moments} kg m²", listed(culprits) or link.name, hint)


def _check_part_inertias(robot: Robot, impossible: Collection[int], log: Diagnostics) -> None:
    """W-INERTIA, once for each kind of part, in links whose own inertia is possible."""
    reported: set[int] = set()
    for link in robot.links:
        if link.given is not None or _has_impossible_inertia(link):
            continue
        for part in link.parts:
            if id(part.inertial) in impossible and id(part.inertial) not in reported:
                reported.add(id(part.inertial))
                text = f"no solid can have the part's inertia; that of its link {link.name!r} is possible"
                log.report("W-INERTIA", text, part.name, f"{_CORRECT}parts")


def with_least_inertias(robot: Robot, log: Diagnostics) -> Robot:
    """The robot with the least mass and inertia that MuJoCo takes on links that have less (W-INERTIA-LEAST):
    those of a robot that is a few millimetres long."""
    links = []
    for link in robot.links:
        own = link.inertial
        found = own if own.mass <= 0 or not is_physical(own) else large_enough(own)
        if found is not own:
            was, now = (_weight(one) for one in (own, found))
            text = (
                f"below MuJoCo's least mass or inertia of a moving body ({was}): the least was used ({now})"
            )
            log.report("W-INERTIA-LEAST", text, link.name, _LARGER)
            link = replace(link, inertial=found, given=found)
        links.append(link)
    return replace(robot, links=tuple(links))


def _weight(inertial: Inertial) -> str:
    moments = ", ".join(f"{moment:.4g}" for moment in principal(inertial.inertia))
    return f"{inertial.mass:.4g} kg, {moments} kg m²"


def _moving_without_mass(robot: Robot) -> list[Link]:
    """Of each group of links that moves as one and weighs nothing, the first."""
    rigid = nx.utils.UnionFind([link.name for link in robot.links])
    for joint in robot.joints:
        if joint.type == "fixed":
            rigid.union(joint.parent, joint.child)
    mass: dict[str, float] = {}
    first: dict[str, Link] = {}
    for link in robot.links:
        group = rigid[link.name]
        mass[group] = mass.get(group, 0.0) + link.inertial.mass
        first.setdefault(group, link)
    if robot.base.fixed:
        del first[rigid[robot.root.name]]
    return [link for group, link in first.items() if mass[group] <= 0]
