"""Every link, joint and frame is there by name, and nothing else."""

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.same.found import ReadRobot


def names(read: ReadRobot) -> Check:
    """One result: the names that are missing, then those that are not the robot's."""
    found, expected = read.found(), read.expected()
    missing = [(tag, name) for tag, every in expected.items() for name in sorted(every - found[tag])]
    added = [(tag, name) for tag, every in found.items() for name in sorted(every - expected[tag])]
    detail = ", ".join(count(len(found[tag]), read.words.tags.get(tag, tag)) for tag in ("link", "joint"))
    if missing:
        detail = f"missing: {', '.join(sorted(name for _, name in missing))}"
    elif added:
        detail = f"not the robot's: {', '.join(sorted(name for _, name in added))}"
    findings = [
        Finding(named(read.words.tags.get(tag, tag), name), "name", message)
        for every, message in ((missing, "there is none of this name"), (added, "is not one of the robot's"))
        for tag, name in every
    ]
    return read.within("links and joints", float(len(findings)), 0.0, detail, findings)
