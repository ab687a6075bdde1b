"""The mass of the whole robot, as a scale shows it: what is estimated is scaled to it."""

from dataclasses import replace

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import merged, moved, scaled
from linkwright.stages.robot.model.robot import Inertial, Link, Robot
from linkwright.stages.robot.text.plural import count

WHERE = "mass.total"


def with_total(robot: Robot, total: float | None, log: Diagnostics) -> Robot:
    """The robot with a total mass [kg], by one factor for all estimated masses and their inertias.

    I-MASS-TOTAL tells the factor; E-MASS where nothing is estimated, or what is known weighs as much already.
    An estimate in a link whose mass is given does not count.
    """
    if total is None or log.problems:
        return robot
    guessed = [part for link in robot.links if link.given is None for part in link.parts if part.estimated]
    guess = sum(part.inertial.mass for part in guessed)
    known = sum(link.inertial.mass for link in robot.links) - guess
    if guess == 0.0:
        text = f"the robot weighs {known:.6g} kg, and no mass is estimated that may be scaled to {total:g} kg"
        hint = "correct the masses that are wrong: mass: {parts: {...}, links: {...}}"
        log.report("E-MASS", text, WHERE, hint)
        return robot
    parts = count(len(guessed), "part")
    if total <= known:
        text = f"{total:g} kg is too little: beside {parts} with estimated masses, it weighs {known:.6g} kg"
        hint = "correct the known masses that are too large (mass.parts, mass.links), or the total"
        log.report("E-MASS", text, WHERE, hint)
        return robot
    factor = (total - known) / guess
    change = f"by {factor:.4g}, from {guess:.4g} kg to {total - known:.4g} kg"
    log.report("I-MASS-TOTAL", f"the estimated masses of {parts} are scaled {change}", WHERE)
    # Parts of a kind share one inertial, and go on doing so.
    made = {id(part.inertial): scaled(part.inertial, part.inertial.mass * factor) for part in guessed}
    return replace(robot, links=tuple(_scaled(link, made) for link in robot.links))


def _scaled(link: Link, made: dict[int, Inertial]) -> Link:
    if link.given is not None or not any(part.estimated for part in link.parts):
        return link
    parts = tuple(
        replace(part, inertial=made[id(part.inertial)]) if part.estimated else part for part in link.parts
    )
    whole = merged([moved(part.inertial, part.link_from_part) for part in parts])
    return replace(link, parts=parts, inertial=whole)
