"""The checks of a file that no engine reads, by the reader of its format."""

from collections.abc import Callable, Iterator
from pathlib import Path

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check
from linkwright.stages.validate.same.found import ReadRobot, UnreadableFile
from linkwright.stages.validate.same.joints import joints
from linkwright.stages.validate.same.loops import loops
from linkwright.stages.validate.same.masses import masses
from linkwright.stages.validate.same.motion import motion, poses
from linkwright.stages.validate.same.names import names
from linkwright.stages.validate.same.relations import relations

CHECKS = (masses, poses, motion, joints, relations, loops)
"""In the order of the report."""


def checks_by(
    reader: Callable[[Path, Written], ReadRobot], path: Path, written: Written, *, quick: bool
) -> Iterator[Check]:
    """The results. `quick`: only whether the file can be read. Where a link or joint is missing, the checks
    that look for each by its name are left out."""
    try:
        read = reader(path, written)
    except UnreadableFile as error:
        yield Check(f"{path.name}: reads", False, str(error))
        return
    yield Check(f"{path.name}: reads", True, "no errors")
    if quick:
        return
    yield from read.first_checks()
    complete = names(read)
    yield complete
    if complete.passed:
        for check in CHECKS:
            yield from check(read)
        yield from read.own_checks()
