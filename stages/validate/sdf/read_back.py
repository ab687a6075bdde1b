"""The run of the checks of an SDF: no engine is needed, since its own reader has its kinematics."""

from collections.abc import Iterator
from pathlib import Path

from stages.formats.sdf.names import sdf_names
from stages.formats.sdf.parse import SdfError, parse_sdf
from stages.robot.check import Check
from stages.robot.model import Robot
from stages.validate.sdf.checks import CHECKS, links_and_joints
from stages.validate.sdf.known import ReadSdf

CODE = "C-SDF"


def check_file(path: Path, robot: Robot, *, quick: bool) -> Iterator[Check]:
    """The results. `quick`: only whether it can be read. Where a link or joint is missing, the checks that
    look for each by its name are left out."""
    try:
        model = parse_sdf(path.read_bytes())
    except SdfError as error:
        yield Check(f"{path.name}: reads", False, str(error))
        return
    yield Check(f"{path.name}: reads", True, "no errors")
    if quick:
        return
    given = ReadSdf(path.name, model, robot, sdf_names(robot))
    complete = links_and_joints(given)
    yield complete
    if complete.passed:
        for check in CHECKS:
            yield from check(given)
