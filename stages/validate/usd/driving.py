"""What the joints of a USD resist, where they start, what drives them and what they follow, against the
robot's."""

from collections.abc import Iterator, Mapping

from linkwright.stages.formats.usd.drives import Drives
from linkwright.stages.formats.usd.joint_facts import JointFacts, driven, mimic, resistance, state
from linkwright.stages.formats.usd.names import UsdNames
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.robot import Configuration, Dof, Robot
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.usd.reader import ReadUsdJoint, UsdRobot

SINGLE = 1e-6
"""Attributes are in single precision, relatively; positions below 1 [deg or m] are so to this."""

POSITIONS = ("osition", "offset", "Coef0")
"""Endings of the names of positions."""

UNSAID = {
    "physics:jointEnabled": 1.0,
    "physics:collisionEnabled": 0.0,
    "physics:breakForce": float("inf"),
    "physics:breakTorque": float("inf"),
}
"""What UsdPhysics has of a joint that a build leaves unsaid, by attribute."""


Said = Mapping[str, float] | Mapping[str, str]
"""Attributes of numbers, or of words, by name."""


def driving(
    usd: UsdRobot, robot: Robot, names: UsdNames, drives: Drives, home: Configuration
) -> Iterator[Finding]:
    """Of each joint, against what a build says of it: nothing of one that closes a loop."""
    dofs = {dof.name: dof for joint in robot.joints for dof in joint.dofs if dof.kind != "free"}
    between = [dof for loop in robot.loops for dof in loop.dofs[:-1]]
    said = [*dofs.values(), *between]
    wanted = {names.joints[dof.name]: _said(dof, drives, home) for dof in said}
    for relation in robot.relations:
        both = dofs[relation.follower], dofs[relation.driver]
        own, other = (usd.joints[names.joints[dof.name]] for dof in both)
        follows = mimic(relation, *both, (own.letter, other.letter))
        targets = {name: names.joints[dof] for name, dof in follows.targets.items()}
        wanted[names.joints[relation.follower]] |= JointFacts(
            follows.schemas, follows.numbers, follows.words, targets
        )
    for name, joint in usd.joints.items():
        yield from _differences(named("def", name), joint, wanted.get(name, JointFacts()))


def _said(dof: Dof, drives: Drives, home: Configuration) -> JointFacts:
    facts, value = resistance(dof), home[dof.name]
    if isinstance(value, tuple):
        return facts
    drive = drives.of.get(dof.name)
    return facts | state(dof, value) | (driven(dof, drive) if drive is not None else JointFacts())


def _differences(element: str, joint: ReadUsdJoint, wanted: JointFacts) -> Iterator[Finding]:
    found = joint.facts
    for schema in wanted.schemas:
        if schema not in found.schemas:
            yield differs(element, "apiSchemas", f"no {schema}", schema)
    yield from _each(element, found.numbers, {**_default(found), **wanted.numbers})
    yield from _each(element, found.words, wanted.words)
    yield from _each(element, found.targets, wanted.targets)


def _default(found: JointFacts) -> dict[str, float]:
    """Of what is said, and need not be: what it must be."""
    return {name: value for name, value in UNSAID.items() if name in found.numbers}


def _each(element: str, found: Said, wanted: Said) -> Iterator[Finding]:
    for name in sorted({*found, *wanted}):
        if not _alike(name, found.get(name), wanted.get(name)):
            yield differs(element, name, found.get(name), wanted.get(name))


def _alike(name: str, found: float | str | None, wanted: float | str | None) -> bool:
    if isinstance(found, float) and isinstance(wanted, float):
        least = 1.0 if name.endswith(POSITIONS) else 0.0
        return found == wanted or abs(found - wanted) <= SINGLE * max(least, abs(wanted))
    return found == wanted
