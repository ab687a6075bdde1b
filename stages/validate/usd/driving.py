"""Compares the joints of a USD with the robot's: resistance, start, drives and relations."""

from collections.abc import Iterator, Mapping

from linkwright.stages.formats.usd.drives import Drives
from linkwright.stages.formats.usd.joint_facts import (
    JointFacts,
    joint_drive,
    joint_mimic,
    joint_state,
    resistance,
)
from linkwright.stages.formats.usd.names import UsdNames
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.robot import Configuration, Dof, Robot
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.usd.reader import ReadUsdJoint, UsdRobot

SINGLE_PRECISION = 1e-6
"""Relative tolerance of attributes in single precision, which is absolute for positions below 1 [deg, m]."""

POSITION_ENDINGS = ("osition", "offset", "Coef0")
"""Endings of the names of attributes that are positions."""

DEFAULTS = {
    "physics:jointEnabled": 1.0,
    "physics:collisionEnabled": 0.0,
    "physics:breakForce": float("inf"),
    "physics:breakTorque": float("inf"),
}
"""UsdPhysics's defaults for attributes of a joint that a build does not write."""


Attributes = Mapping[str, float] | Mapping[str, str]
"""Attributes of numbers, or of words, by name."""


def driving(
    usd: UsdRobot, robot: Robot, names: UsdNames, drives: Drives, home: Configuration
) -> Iterator[Finding]:
    """Compares each joint with the attributes that a build writes for it. A joint that closes a loop has
    none."""
    dofs = {dof.name: dof for joint in robot.joints for dof in joint.dofs if dof.kind != "free"}
    between = [dof for loop in robot.loops for dof in loop.dofs[:-1]]
    written = [*dofs.values(), *between]
    expected = {names.joints[dof.name]: _expected(dof, drives, home) for dof in written}
    for relation in robot.relations:
        follower_and_driver = dofs[relation.follower], dofs[relation.driver]
        read, read_driver = (usd.joints[names.joints[dof.name]] for dof in follower_and_driver)
        follows = joint_mimic(relation, *follower_and_driver, (read.letter, read_driver.letter))
        targets = {name: names.joints[dof] for name, dof in follows.targets.items()}
        expected[names.joints[relation.follower]] |= JointFacts(
            follows.schemas, follows.numbers, follows.tokens, targets
        )
    for name, joint in usd.joints.items():
        yield from _differences(named("def", name), joint, expected.get(name, JointFacts()))


def _expected(dof: Dof, drives: Drives, home: Configuration) -> JointFacts:
    facts, value = resistance(dof), home[dof.name]
    if isinstance(value, tuple):
        return facts
    drive = drives.of.get(dof.name)
    return facts | joint_state(dof, value) | (joint_drive(dof, drive) if drive is not None else JointFacts())


def _differences(element: str, joint: ReadUsdJoint, expected: JointFacts) -> Iterator[Finding]:
    facts = joint.facts
    for schema in expected.schemas:
        if schema not in facts.schemas:
            yield differs(element, "apiSchemas", f"no {schema}", schema)
    yield from _attribute_differences(element, facts.numbers, {**_defaults(facts), **expected.numbers})
    yield from _attribute_differences(element, facts.tokens, expected.tokens)
    yield from _attribute_differences(element, facts.targets, expected.targets)


def _defaults(facts: JointFacts) -> dict[str, float]:
    """Returns the defaults of the attributes that a file may set although a build does not."""
    return {name: value for name, value in DEFAULTS.items() if name in facts.numbers}


def _attribute_differences(element: str, actual: Attributes, expected: Attributes) -> Iterator[Finding]:
    for name in sorted({*actual, *expected}):
        if not _is_same(name, actual.get(name), expected.get(name)):
            yield differs(element, name, actual.get(name), expected.get(name))


def _is_same(name: str, actual: float | str | None, expected: float | str | None) -> bool:
    if isinstance(actual, float) and isinstance(expected, float):
        least = 1.0 if name.endswith(POSITION_ENDINGS) else 0.0
        return actual == expected or abs(actual - expected) <= SINGLE_PRECISION * max(least, abs(expected))
    return actual == expected
