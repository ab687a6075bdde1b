"""Compares the joints of a USD with the robot's: resistance, start, drives and relations."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

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

FLOAT32_TOLERANCE = 1e-6
"""Relative tolerance of attributes in single precision, which is absolute for positions below 1 [deg, m]."""

POSITION_ENDINGS = ("osition", "offset", "Coef0")
"""Endings of the names of attributes that are positions, such as `position` and `targetPosition`."""

DEFAULTS = {
    "physics:jointEnabled": 1.0,
    "physics:collisionEnabled": 0.0,
    "physics:breakForce": float("inf"),
    "physics:breakTorque": float("inf"),
}
"""UsdPhysics's defaults for attributes of a joint that a build does not write."""

Attributes = Mapping[str, float] | Mapping[str, str]
"""Attributes of numbers, or of words, by name."""


def driving_findings(
    usd: UsdRobot, robot: Robot, names: UsdNames, drives: Drives, home: Configuration
) -> Iterator[Finding]:
    """Compares each joint with the attributes that a build writes for it. A joint that closes a loop, outside
    the articulation, has none."""
    dofs = {dof.name: dof for joint in robot.joints for dof in joint.dofs if dof.kind != "free"}
    # Only the last joint of a loop's chain closes the loop.
    dofs_before_last = [dof for loop in robot.loops for dof in loop.dofs[:-1]]
    expected = {
        names.joints[dof.name]: _expected_facts(dof, drives, home)
        for dof in (*dofs.values(), *dofs_before_last)
    }
    for relation in robot.relations:
        follower, driver = dofs[relation.follower], dofs[relation.driver]
        # The attributes of PhysX name the axes of both joints, which the file chooses.
        axes = (
            usd.joints[names.joints[follower.name]].axis_name,
            usd.joints[names.joints[driver.name]].axis_name,
        )
        mimic = joint_mimic(relation, follower, driver, axes)
        targets = {name: names.joints[dof] for name, dof in mimic.targets.items()}
        expected[names.joints[follower.name]] |= replace(mimic, targets=targets)
    for name, joint in usd.joints.items():
        yield from _differences(named("def", name), joint, expected.get(name, JointFacts()))


def _expected_facts(dof: Dof, drives: Drives, home: Configuration) -> JointFacts:
    """Returns the attributes of a dof's joint, without relations. A ball has neither state nor drive."""
    facts, value = resistance(dof), home[dof.name]
    if isinstance(value, tuple):
        return facts
    drive = drives.by_dof.get(dof.name)
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
        min_scale = 1.0 if name.endswith(POSITION_ENDINGS) else 0.0
        tolerance = FLOAT32_TOLERANCE * max(min_scale, abs(expected))
        # The tolerance of an infinite number would be infinite.
        return actual == expected or (math.isfinite(expected) and abs(actual - expected) <= tolerance)
    return actual == expected
