"""Texts about a robot for people: shortened names, and values in degrees, millimetres and kilograms."""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence

from linkwright.stages.robot.model.robot import Dof, Joint, Link, Relation, Robot
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import columns, printable

_UNITS = {"turn": (math.degrees(1.0), "deg"), "slide": (1e3, "mm")}


def shortened(text: str, room: float, measure: Callable[[str], float] = columns) -> str:
    """`text` without as much of its middle as must go to fit `room`, in the unit of `measure`."""
    text = printable(text)
    if measure(text) <= room:
        return text
    for kept in range(min(len(text) - 1, int(room)), 0, -1):
        tail = kept // 2
        short = text[: kept - tail] + "…" + text[len(text) - tail :]
        if measure(short) <= room:
            return short
    return "…"


def decimal(value: float) -> str:
    """A number with four significant digits."""
    return f"{round(value, 9) + 0.0:.4g}"


def kilograms(mass: float) -> str:
    return f"{mass:.4g} kg"


def value(dof: Dof, amount: float) -> str:
    """An angle [rad] in degrees, or a length [m] in millimetres."""
    factor, unit = _UNITS[dof.kind]
    return f"{decimal(amount * factor)} {unit}"


def limits(dof: Dof) -> str:
    """The range of a dof: "-90..90 deg", "≥ 0 mm", "cone 30 deg", or "free"."""
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
    """The name of a dof within its joint: "turn", "x"; "" where it is the only one."""
    return "" if dof.name == joint.name else dof.name.removeprefix(f"{joint.name}_")


def motions(joint: Joint) -> list[tuple[Dof, str]]:
    """Each dof of a joint and its range in words: "-90..90 deg", or "turn -90..90 deg" of several."""
    return [(dof, f"{coordinate(joint, dof)} {limits(dof)}".strip()) for dof in joint.dofs]


def rules(robot: Robot, room: float = math.inf) -> dict[str, str]:
    """The rule of each follower: "-1.5 × drive + 3 deg", the driver's name within `room` columns; where
    turns and slides meet the factor has its unit."""
    dofs = {dof.name: dof for dof in robot.dofs}
    return {one.follower: _rule(one, dofs[one.follower], dofs[one.driver], room) for one in robot.relations}


def _rule(relation: Relation, follower: Dof, driver: Dof, room: float) -> str:
    (to, unit), (per, from_unit) = _UNITS[follower.kind], _UNITS[driver.kind]
    factor = decimal(relation.multiplier * to / per)
    ratio = factor if follower.kind == driver.kind else f"{factor} {unit}/{from_unit}"
    driver_name = shortened(relation.driver, room)
    shift = decimal(abs(relation.offset) * to)
    if shift == "0":
        return f"{ratio} × {driver_name}"
    return f"{ratio} × {driver_name} {'-' if relation.offset < 0 else '+'} {shift} {unit}"


def leaf(name: str) -> str:
    """The part's own name, without the sub-assemblies before it."""
    return name.rsplit("/", 1)[-1]


def part_names(link: Link) -> list[str]:
    """The parts of a link, the heaviest first; equal ones are counted."""
    weights: dict[str, list[float]] = {}
    for part in link.parts:
        weights.setdefault(re.sub(r" <\d+>$", "", leaf(part.name)), []).append(part.inertial.mass)
    order = sorted(weights, key=lambda name: (-sum(weights[name]), name))
    return [name if len(weights[name]) == 1 else f"{name} ×{len(weights[name])}" for name in order]


def frames_on(robot: Robot) -> Mapping[str, Sequence[str]]:
    """The names of the frames on each link that has any."""
    found: dict[str, list[str]] = {}
    for frame in robot.frames:
        found.setdefault(frame.link, []).append(frame.name)
    return found


def is_origin(robot: Robot, link: Link) -> bool:
    """Whether a link is only the assembly's origin."""
    return link is robot.root and link.name == "world" and not link.parts


def totals(robot: Robot) -> str:
    """The robot in one line."""
    parts = sum(len(link.parts) for link in robot.links)
    nouns: Iterable[tuple[int, str]] = (
        (len(robot.links), "link"),
        (len(robot.joints), "joint"),
        (parts, "part"),
        (len(robot.relations), "relation"),
        (len(robot.loops), "loop"),
        (len(robot.frames), "frame"),
    )
    found = [count(number, noun) for number, noun in nouns if number or noun in ("link", "joint")]
    return ", ".join([*found, kilograms(sum(link.inertial.mass for link in robot.links))])


def mobility(robot: Robot) -> str:
    """The degrees of freedom of the mechanism, in one line."""
    how = robot.mobility
    text = f"{count(how.dof, 'degree')} of freedom (by rank at the saved pose; {how.gruebler} by Grübler), "
    return text + f"{count(how.coordinates, 'coordinate')}"


def standing(robot: Robot) -> str:
    """Whether the base is fixed or free, and why."""
    return f"{'fixed' if robot.base.fixed else 'free'} base: {printable(robot.base.reason)}"
