"""Checks a file that no physics engine reads: its format's reader parses it, the comparisons judge it."""

from collections.abc import Callable, Iterator
from pathlib import Path

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check
from linkwright.stages.validate.same.joints import compare_joints
from linkwright.stages.validate.same.loops import compare_loops
from linkwright.stages.validate.same.masses import compare_masses
from linkwright.stages.validate.same.motion import compare_motion, compare_with_cad
from linkwright.stages.validate.same.names import compare_names
from linkwright.stages.validate.same.read_robot import ReadRobot, UnreadableFile
from linkwright.stages.validate.same.relations import compare_relations

CHECKS = (compare_masses, compare_with_cad, compare_motion, compare_joints, compare_relations, compare_loops)
"""The comparisons, in the order in which the report lists them."""


def run_checks(
    reader: Callable[[Path, Written], ReadRobot], path: Path, written: Written, *, quick: bool
) -> Iterator[Check]:
    """Reads a file and yields the results of its checks. `quick`: check only that the file can be read.

    If a link or joint is missing, the checks that look elements up by name are skipped.
    """
    try:
        read_robot = reader(path, written)
    except UnreadableFile as error:
        yield Check(f"{path.name}: reads", False, str(error))
        return
    yield Check(f"{path.name}: reads", True, "no errors")
    if quick:
        return
    yield from read_robot.first_checks()
    names_check = compare_names(read_robot)
    yield names_check
    # With a name missing, the other checks would fail on look-ups.
    if names_check.passed:
        for check in CHECKS:
            yield from check(read_robot)
        yield from read_robot.own_checks()
