"""Compares the relations of joints with the robot's, with their numbers."""

from collections.abc import Iterator

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Relation
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE
from linkwright.stages.validate.same.read_robot import FoundMimic, ReadRobot


def compare_relations(read: ReadRobot) -> Iterator[Check]:
    """Yields a single result."""
    read_mimics = read.mimics()
    if read_mimics is None:
        return
    mimics = sorted(read_mimics, key=lambda mimic: not mimic.active)
    wrong: dict[str, Finding] = {}
    for relation in read.robot.relations:
        finding = _difference(read, relation, mimics)
        wrong |= {relation.name: finding} if finding else {}
    for mimic in mimics:
        if mimic.active:
            message = f"follows {mimic.driver or 'nothing'}, which the robot does not have it do"
            wrong[mimic.follower] = Finding(
                named("joint", mimic.follower), read.attribute_names.mimic[0], message
            )
    number = count(len(read.robot.relations), "relation")
    detail = f"differ: {', '.join(wrong)}" if wrong else f"{number} with the numbers of the robot"
    yield read.within("relations", float(len(wrong)), 0.0, detail, wrong.values())


def _difference(read: ReadRobot, relation: Relation, mimics: list[FoundMimic]) -> Finding | None:
    """Returns the error of a relation, which a file may solve for either of its dofs. Takes the relation's
    mimic out of `mimics`."""
    element = read.element("relation", relation.name)
    factor, offset = relation.multiplier, relation.offset
    mimic = _take_mimic(mimics, relation.follower, relation.driver)
    if mimic is None and factor:
        mimic = _take_mimic(mimics, relation.driver, relation.follower)
        factor, offset = 1 / factor, -offset / factor
    if mimic is None:
        message = f"nothing says that {relation.follower} follows {relation.driver}"
        return Finding(element, read.attribute_names.mimic[0], message)
    if not mimic.active:
        return Finding(element, "active", f"is false, so that {relation.follower} does not follow")
    allowed = ENGINE_TOLERANCE * max(1.0, abs(factor), abs(offset))
    actual, expected = (mimic.multiplier, mimic.offset), (factor, offset)
    are_wrong = [not abs(value - goal) <= allowed for value, goal in zip(actual, expected, strict=True)]
    if not any(are_wrong):
        return None
    if read.attribute_names.mimic[0] == read.attribute_names.mimic[1]:
        return differs(element, read.attribute_names.mimic[0], actual[::-1], expected[::-1])
    at = are_wrong.index(True)
    return differs(element, read.attribute_names.mimic[at], actual[at], expected[at])


def _take_mimic(mimics: list[FoundMimic], follower: str, driver: str) -> FoundMimic | None:
    for mimic in mimics:
        if (mimic.follower, mimic.driver) == (follower, driver):
            mimics.remove(mimic)
            return mimic
    return None
