"""Writes texts about a robot: shortened names, and values in degrees, millimetres and kilograms."""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence

from linkwright.stages.robot.model.robot import Dof, Joint, Link, Relation, Robot
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import columns, printable

_UNITS = {"turn": (math.degrees(1.0), "deg"), "slide": (1e3, "mm")}


def shortened(text: str, room: float, measure: Callable[[str], float] = columns) -> str:
    """Returns `text`, shortened in its middle until `measure` of it is at most `room`. `measure`: function
    that returns the width of a text, by default its columns."""
    text = printable(text)
    if measure(text) <= room:
        return text
    for length in range(min(len(text) - 1, int(room)), 0, -1):
        tail = length // 2
        shortened_text = text[: length - tail] + "…" + text[len(text) - tail :]
        if measure(shortened_text) <= room:
            return shortened_text
    return "…"


def decimal(number: float) -> str:
    """Formats a number with four significant digits."""
    return f"{round(number, 9) + 0.0:.4g}"


def kilograms(mass: float) -> str:
    return f"{mass:.4g} kg"


def value(dof: Dof, amount: float) -> str:
    """Formats an angle [rad] in degrees, or a length [m] in millimetres."""
    factor, unit = _UNITS[dof.kind]
    return f"{decimal(amount * factor)} {unit}"


def limits(dof: Dof) -> str:
    """Formats the range of a dof: "-90..90 deg", "≥ 0 mm", "cone 30 deg", or "free"."""
    lower, upper = dof.limits.lower, dof.limits.upper
    if dof.kind == "ball":
        return "free" if upper is None else f"cone {decimal(math.degrees(upper))} deg"
    if dof.kind == "free" or (lower is None and upper is None):
        return "free"
    if lower is None and upper is not None:
        return f"≤ {value(dof, upper)}"
    if upper is None and lower is not None:
        return f"≥ {value(dof, lower)}"
    factor, unit = _UNITS[dof.kind]
    return f"{decimal((lower or 0.0) * factor)}..{decimal((upper or 0.0) * factor)} {unit}"


def coordinate(joint: Joint, dof: Dof) -> str:
    """Returns the name of a dof within its joint: "turn", "x"; "" for a single dof."""
    return "" if dof.name == joint.name else dof.name.removeprefix(f"{joint.name}_")


def motions(joint: Joint) -> list[tuple[Dof, str]]:
    """Returns each dof of a joint with the text of its range: "-90..90 deg", or for several dofs "turn
    -90..90 deg"."""
    return [(dof, f"{coordinate(joint, dof)} {limits(dof)}".strip()) for dof in joint.dofs]


def rules(robot: Robot, room: float = math.inf) -> dict[str, str]:
    """Returns the rule of each follower, such as "-1.5 × drive + 3 deg"; the driver's name is shortened to
    `room` columns. Between a turn and a slide the factor has a unit."""
    dofs = {dof.name: dof for dof in robot.dofs}
    return {
        relation.follower: _rule(relation, dofs[relation.follower], dofs[relation.driver], room)
        for relation in robot.relations
    }


def _rule(relation: Relation, follower: Dof, driver: Dof, room: float) -> str:
    (scale, unit), (driver_scale, driver_unit) = _UNITS[follower.kind], _UNITS[driver.kind]
    factor = decimal(relation.multiplier * scale / driver_scale)
    ratio = factor if follower.kind == driver.kind else f"{factor} {unit}/{driver_unit}"
    driver_name = shortened(relation.driver, room)
    shift = decimal(abs(relation.offset) * scale)
    if shift == "0":
        return f"{ratio} × {driver_name}"
    return f"{ratio} × {driver_name} {'-' if relation.offset < 0 else '+'} {shift} {unit}"


def leaf(name: str) -> str:
    """Returns the part's own name, without the sub-assemblies before it."""
    return name.rsplit("/", 1)[-1]


def part_names(link: Link) -> list[str]:
    """Returns the names of a link's parts, the heaviest first; equal parts are counted, as in "screw ×4"."""
    masses: dict[str, list[float]] = {}
    for part in link.parts:
        masses.setdefault(re.sub(r" <\d+>$", "", leaf(part.name)), []).append(part.inertial.mass)
    order = sorted(masses, key=lambda name: (-sum(masses[name]), name))
    return [name if len(masses[name]) == 1 else f"{name} ×{len(masses[name])}" for name in order]


def frames_on(robot: Robot) -> Mapping[str, Sequence[str]]:
    """Returns the names of the frames on each link that has any."""
    by_link: dict[str, list[str]] = {}
    for frame in robot.frames:
        by_link.setdefault(frame.link, []).append(frame.name)
    return by_link


def is_origin(robot: Robot, link: Link) -> bool:
    """Tells whether a link is only the assembly's origin."""
    return link is robot.root and link.name == "world" and not link.parts


def totals_line(robot: Robot) -> str:
    """Returns a line with the numbers of the robot's links, joints and so on, and its mass."""
    parts = sum(len(link.parts) for link in robot.links)
    nouns: Iterable[tuple[int, str]] = (
        (len(robot.links), "link"),
        (len(robot.joints), "joint"),
        (parts, "part"),
        (len(robot.relations), "relation"),
        (len(robot.loops), "loop"),
        (len(robot.frames), "frame"),
    )
    counts = [count(number, noun) for number, noun in nouns if number or noun in ("link", "joint")]
    return ", ".join([*counts, kilograms(sum(link.inertial.mass for link in robot.links))])


def mobility(robot: Robot) -> str:
    """Returns a line about the degrees of freedom of the mechanism."""
    degrees = robot.mobility
    text = f"{count(degrees.dof, 'degree')} of freedom "
    text += f"(by rank at the saved pose; {degrees.gruebler} by Grübler), "
    return text + f"{count(degrees.coordinates, 'coordinate')}"


def base_line(robot: Robot) -> str:
    """Tells whether the base is fixed or free, and why."""
    return f"{'fixed' if robot.base.fixed else 'free'} base: {printable(robot.base.reason)}"
