"""What the checks say of the SRDF in a folder, against its robot.json alone."""

from pathlib import Path

from stages.formats.described import described
from stages.robot.check import Check
from stages.robot.driven import as_driven
from stages.validate.expected import Expected
from stages.validate.srdf.read_back import check_file


def srdf_checks(folder: Path) -> list[Check]:
    """Of `robot.srdf`."""
    truth = described((folder / "robot.json").read_bytes())
    expected = Expected(truth.actuation, truth.geometry, truth.form, truth.amendments, truth.scene)
    robot = as_driven(truth.robot, truth.actuation)
    return list(check_file(folder / "robot.srdf", robot, expected, quick=False))
