"""Compares the relations of joints with the robot's, with their numbers."""

from collections.abc import Iterator

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Relation
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE
from linkwright.stages.validate.same.read_robot import FoundMimic, ReadRobot


def compare_relations(read_robot: ReadRobot) -> Iterator[Check]:
    """Yields a single result, unless only the checks of the format compare relations."""
    read_mimics = read_robot.mimics()
    if read_mimics is None:
        return
    # An inactive mimic counts for a relation only if no active mimic does.
    mimics = sorted(read_mimics, key=lambda mimic: not mimic.active)
    finding_by_joint: dict[str, Finding] = {}
    for relation in read_robot.robot.relations:
        finding = _difference(read_robot, relation, mimics)
        finding_by_joint |= {relation.name: finding} if finding else {}
    for mimic in mimics:
        if mimic.active:
            message = f"follows {mimic.driver or 'nothing'}, which the robot does not have it do"
            finding_by_joint[mimic.follower] = Finding(
                named("joint", mimic.follower), read_robot.attribute_names.mimic[0], message
            )
    number = count(len(read_robot.robot.relations), "relation")
    detail = f"{number} with the numbers of the robot"
    if finding_by_joint:
        detail = f"differ: {', '.join(finding_by_joint)}"
    yield read_robot.within("relations", float(len(finding_by_joint)), 0.0, detail, finding_by_joint.values())


def _difference(read_robot: ReadRobot, relation: Relation, mimics: list[FoundMimic]) -> Finding | None:
    """Returns the error of a relation, which a file may solve for either of its dofs. Takes the relation's
    mimic out of `mimics`."""
    element = read_robot.element("relation", relation.name)
    factor, offset = relation.multiplier, relation.offset
    mimic = _take_mimic(mimics, relation.follower, relation.driver)
    if mimic is None and factor:
        mimic = _take_mimic(mimics, relation.driver, relation.follower)
        # From follower = factor · driver + offset.
        factor, offset = 1 / factor, -offset / factor
    if mimic is None:
        message = f"nothing says that {relation.follower} follows {relation.driver}"
        return Finding(element, read_robot.attribute_names.mimic[0], message)
    if not mimic.active:
        return Finding(element, "active", f"is false, so that {relation.follower} does not follow")
    allowed = ENGINE_TOLERANCE * max(1.0, abs(factor), abs(offset))
    actual, expected = (mimic.multiplier, mimic.offset), (factor, offset)
    differ = [not abs(value - goal) <= allowed for value, goal in zip(actual, expected, strict=True)]
    if not any(differ):
        return None
    if read_robot.attribute_names.mimic[0] == read_robot.attribute_names.mimic[1]:
        return differs(element, read_robot.attribute_names.mimic[0], actual[::-1], expected[::-1])
    index = differ.index(True)
    return differs(element, read_robot.attribute_names.mimic[index], actual[index], expected[index])


def _take_mimic(mimics: list[FoundMimic], follower: str, driver: str) -> FoundMimic | None:
    """Removes the first mimic of two joints from `mimics` and returns it; None without such a mimic."""
    for mimic in mimics:
        if (mimic.follower, mimic.driver) == (follower, driver):
            mimics.remove(mimic)
            return mimic
    return None
