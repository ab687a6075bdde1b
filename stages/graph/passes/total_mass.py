"""Scales the estimated masses so that the whole robot has the mass that a scale shows."""

from dataclasses import replace

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import merged, moved, scaled
from linkwright.stages.robot.model.robot import Inertial, Link, Robot
from linkwright.stages.robot.text.plural import count

WHERE = "mass.total"


def with_total(robot: Robot, total: float | None, log: Diagnostics) -> Robot:
    """Returns the robot with a total mass [kg], by one factor for all estimated masses and their inertias.

    Reports the factor (I-MASS-TOTAL), and E-MASS if nothing is estimated, or if the known masses reach the
    total. An estimate in a link whose mass is given does not count.
    """
    if total is None or log.problems:
        return robot
    guessed = [part for link in robot.links if link.given is None for part in link.parts if part.estimated]
    guess = sum(part.inertial.mass for part in guessed)
    certain = sum(link.inertial.mass for link in robot.links) - guess
    if guess == 0.0:
        text = (
            f"the robot weighs {certain:.6g} kg, and no mass is estimated that may be scaled to {total:g} kg"
        )
        hint = "correct the masses that are wrong: mass: {parts: {...}, links: {...}}"
        log.report("E-MASS", text, WHERE, hint)
        return robot
    parts = count(len(guessed), "part")
    if total <= certain:
        text = f"{total:g} kg is too little: beside {parts} with estimated masses, it weighs {certain:.6g} kg"
        hint = "correct the known masses that are too large (mass.parts, mass.links), or the total"
        log.report("E-MASS", text, WHERE, hint)
        return robot
    factor = (total - certain) / guess
    change = f"by {factor:.4g}, from {guess:.4g} kg to {total - certain:.4g} kg"
    log.report("I-MASS-TOTAL", f"the estimated masses of {parts} are scaled {change}", WHERE)
    # Parts of a kind share an inertial, and go on doing so.
    inertials = {id(part.inertial): scaled(part.inertial, part.inertial.mass * factor) for part in guessed}
    return replace(robot, links=tuple(_scale_link(link, inertials) for link in robot.links))


def _scale_link(link: Link, inertials: dict[int, Inertial]) -> Link:
    if link.given is not None or not any(part.estimated for part in link.parts):
        return link
    parts = tuple(
        replace(part, inertial=inertials[id(part.inertial)]) if part.estimated else part
        for part in link.parts
    )
    inertial = merged([moved(part.inertial, part.link_from_part) for part in parts])
    return replace(link, parts=parts, inertial=inertial)
