"""Scales the estimated masses so that the whole robot has the mass that a scale shows."""

from dataclasses import replace

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import merged, moved, scaled
from linkwright.stages.robot.model.robot import Inertial, Link, Robot
from linkwright.stages.robot.text.plural import count

_CONFIG_KEY = "mass.total"


def scale_to_total_mass(robot: Robot, total_mass: float | None, log: Diagnostics) -> Robot:
    """Scales all estimated masses, and their inertias, by a common factor, so that the robot has `total_mass`
    [kg].

    Reports the factor as I-MASS-TOTAL. Reports E-MASS if no mass is estimated, or if the known masses reach
    the total. The estimate of a part does not count if the user gave the mass of its whole link. Returns the
    robot unchanged after E-MASS, without a total, and if the log already has problems.
    """
    if total_mass is None or log.problems:
        return robot
    estimated_parts = [
        part for link in robot.links if link.given is None for part in link.parts if part.estimated
    ]
    estimated_mass = sum(part.inertial.mass for part in estimated_parts)
    known_mass = sum(link.inertial.mass for link in robot.links) - estimated_mass
    if estimated_mass == 0.0:
        text = (
            f"the robot weighs {known_mass:.6g} kg, and no mass is estimated: nothing can be "
            f"scaled to reach {total_mass:g} kg"
        )
        hint = "correct the masses that are wrong: mass: {parts: {...}, links: {...}}"
        log.report("E-MASS", text, _CONFIG_KEY, hint)
        return robot
    part_count = count(len(estimated_parts), "part")
    if total_mass <= known_mass:
        text = (
            f"{total_mass:g} kg is too little: without its {part_count} of estimated mass, the robot already "
            f"weighs {known_mass:.6g} kg"
        )
        hint = "correct the known masses that are too large (mass.parts, mass.links), or the total"
        log.report("E-MASS", text, _CONFIG_KEY, hint)
        return robot
    factor = (total_mass - known_mass) / estimated_mass
    change_text = f"by {factor:.4g}, from {estimated_mass:.4g} kg to {total_mass - known_mass:.4g} kg"
    log.report("I-MASS-TOTAL", f"the estimated masses of {part_count} are scaled {change_text}", _CONFIG_KEY)
    # Equal parts share an Inertial object. With its identity as key, they also share the scaled object.
    scaled_inertials = {
        id(part.inertial): scaled(part.inertial, part.inertial.mass * factor) for part in estimated_parts
    }
    return replace(robot, links=tuple(_scale_link(link, scaled_inertials) for link in robot.links))


def _scale_link(link: Link, scaled_inertials: dict[int, Inertial]) -> Link:
    """Replaces the inertials of a link's estimated parts, and computes the link's inertial from its parts.

    `scaled_inertials`: identity of a part's inertial → the scaled inertial.
    """
    if link.given is not None or not any(part.estimated for part in link.parts):
        return link
    parts = tuple(
        replace(part, inertial=scaled_inertials[id(part.inertial)]) if part.estimated else part
        for part in link.parts
    )
    inertial = merged([moved(part.inertial, part.link_from_part) for part in parts])
    return replace(link, parts=parts, inertial=inertial)
