"""Compares the names of links, joints and frames with the robot's."""

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.same.read_robot import ReadRobot


def compare_names(read_robot: ReadRobot) -> Check:
    """Returns a single result, with findings on missing names, then on names that are not the robot's."""
    actual, expected = read_robot.names_found(), read_robot.names_expected()
    missing = [(tag, name) for tag, names in expected.items() for name in sorted(names - actual[tag])]
    surplus = [(tag, name) for tag, names in actual.items() for name in sorted(names - expected[tag])]
    detail = ", ".join(
        count(len(actual[tag]), read_robot.attribute_names.tags.get(tag, tag)) for tag in ("link", "joint")
    )
    if missing:
        detail = f"missing: {', '.join(sorted(name for _, name in missing))}"
    elif surplus:
        detail = f"not the robot's: {', '.join(sorted(name for _, name in surplus))}"
    findings = [
        Finding(named(read_robot.attribute_names.tags.get(tag, tag), name), "name", message)
        for rows, message in ((missing, "is missing"), (surplus, "is not part of the robot"))
        for tag, name in rows
    ]
    return read_robot.within("links and joints", float(len(findings)), 0.0, detail, findings)
