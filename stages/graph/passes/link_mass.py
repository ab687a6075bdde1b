"""Gives links the user's masses and inertias, and checks that a solid can have them."""

from collections.abc import Collection, Mapping
from dataclasses import replace

import networkx as nx

from linkwright.stages.graph.globs import entries_of
from linkwright.stages.graph.mass_section import LinkMassSection
from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import (
    ZERO,
    is_physical,
    principal,
    raised_to_minimum,
    scaled,
    tensor,
)
from linkwright.stages.robot.model.robot import Inertial, Link, Robot, frozen
from linkwright.stages.robot.text.globs import name_list, yaml_key

_CORRECT = "correct the material or the mass override in Onshape, or give inertia in mass."
_LARGER = "check the units of the document, or FASTEN the link to a larger one"
_CORRECT_FILE = (
    "correct it in the file, give mass: {links: {...}}, or set source.bad_inertia: recompute (from the "
    "shapes) or project (to the nearest possible one)"
)


def with_given_masses(robot: Robot, sections: Mapping[str, LinkMassSection], log: Diagnostics) -> Robot:
    """Returns the robot with the mass properties of the key `mass.links`: later entries win, value by value.

    Reports E-GLOB for a glob that matches no link; E-MASS where values of a link without mass are missing.
    """
    names = [{link.name} for link in robot.links]
    overrides = list(sections.values())
    links = []
    for link, entries in zip(
        robot.links, entries_of(names, sections, "mass.links", "link", log), strict=True
    ):
        values: dict[str, object] = {}
        for index in entries:
            values.update({name: value for name, value in overrides[index] if value is not None})
        links.append(_with_mass(link, LinkMassSection.model_validate(values), log) if values else link)
    return replace(robot, links=tuple(links))


def _with_mass(link: Link, section: LinkMassSection, log: Diagnostics) -> Link:
    if link.name == WORLD_LINK:
        return link
    mass = link.inertial.mass if section.mass is None else section.mass
    missing_keys = [name for name in ("mass", "com", "inertia") if getattr(section, name) is None]
    if link.inertial.mass == 0 and missing_keys:
        text = f"the link has no mass of its own: {' and '.join(missing_keys)} must be given too"
        log.report("E-MASS", text, link.name, f"mass: {{links: {{{yaml_key(link.name)}: {{mass: ...}}}}}}")
        return link
    sum_of_parts = scaled(link.inertial, mass) if link.inertial.mass > 0 else ZERO
    override = Inertial(
        mass,
        sum_of_parts.com if section.com is None else frozen(section.com),
        sum_of_parts.inertia if section.inertia is None else tensor(section.inertia),
    )
    return replace(link, inertial=override, given=override)


def check_links(robot: Robot, log: Diagnostics, from_cad: bool = True) -> None:
    """Reports E-MASS for links that move without mass, E-INERTIA for inertias that no solid can have.

    `from_cad`: whether the user corrects them in CAD, not in a file.
    """
    _check_masses(robot, log, from_cad)
    # Parts of a kind share an inertial, which is checked once.
    inertials = {id(part.inertial): part.inertial for link in robot.links for part in link.parts}
    impossible_ids = {
        key for key, inertial in inertials.items() if inertial.mass > 0 and not is_physical(inertial)
    }
    _check_link_inertias(robot, impossible_ids, log, from_cad)
    _check_part_inertias(robot, impossible_ids, log)


def _check_masses(robot: Robot, log: Diagnostics, from_cad: bool) -> None:
    """Reports E-MASS by link, unless parts are known to have no mass, which is reported already.

    Links that fixed joints hold together move together, so some of them may be without mass.
    """
    if any(problem.code == "E-MASS" for problem in log.problems):
        return
    for link in _moving_without_mass(robot):
        text = "the link moves, but has no mass"
        hint = f"mass: {{links: {{{yaml_key(link.name)}: {{mass: ...}}}}}}"
        if link.parts and from_cad:
            text = "the link has no mass: all its parts are sheets or weigh nothing"
            hint = "fasten it to a solid part, or thicken it, in Onshape"
        log.report("E-MASS", text, link.name, hint)


def _has_impossible_inertia(link: Link) -> bool:
    return link.inertial.mass > 0 and not is_physical(link.inertial)


def _check_link_inertias(robot: Robot, impossible: Collection[int], log: Diagnostics, from_cad: bool) -> None:
    """Reports E-INERTIA for each link. `impossible`: ids of the inertials of parts that no solid can have."""
    for link in filter(_has_impossible_inertia, robot.links):
        moments = ", ".join(f"{moment:.4g}" for moment in principal(link.inertial.inertia))
        text = f"no solid can have the inertia of the link {link.name!r}: its principal moments are "
        culprits = [part.name for part in link.parts if id(part.inertial) in impossible]
        hint = f"{_CORRECT}{'parts' if culprits else 'links'}" if from_cad else _CORRECT_FILE
        log.report("E-INERTIA", f"{text}{moments} kg m²", name_list(culprits) or link.name, hint)


def _check_part_inertias(robot: Robot, impossible: Collection[int], log: Diagnostics) -> None:
    """Reports W-INERTIA, once for each kind of part, in links whose own inertia is possible."""
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
    """Raises the mass and the inertia of each link to MuJoCo's minimum (W-INERTIA-LEAST), below which the
    links of a robot of a few millimetres are."""
    links = []
    for link in robot.links:
        inertial = link.inertial
        enlarged_inertial = (
            inertial if inertial.mass <= 0 or not is_physical(inertial) else raised_to_minimum(inertial)
        )
        if enlarged_inertial is not inertial:
            old, new = (_mass_and_moments(body_inertial) for body_inertial in (inertial, enlarged_inertial))
            text = f"below MuJoCo's minimum mass or inertia of a body ({old}): the minimum was used ({new})"
            log.report("W-INERTIA-LEAST", text, link.name, _LARGER)
            link = replace(link, inertial=enlarged_inertial, given=enlarged_inertial)
        links.append(link)
    return replace(robot, links=tuple(links))


def _mass_and_moments(inertial: Inertial) -> str:
    moments = ", ".join(f"{moment:.4g}" for moment in principal(inertial.inertia))
    return f"{inertial.mass:.4g} kg, {moments} kg m²"


def _moving_without_mass(robot: Robot) -> list[Link]:
    """Returns the first link of each group of links that fixed joints hold together, that moves and has no
    mass."""
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
