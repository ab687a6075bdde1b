"""What the checks say of the SRDF in a folder, against its robot.json alone."""

from dataclasses import replace
from pathlib import Path

from linkwright.stages.formats.described import described
from linkwright.stages.robot.check import Check
from linkwright.stages.validate.srdf.read_back import check_file


def srdf_checks(folder: Path) -> list[Check]:
    """Of `robot.srdf`."""
    truth = described((folder / "robot.json").read_bytes())
    written = replace(truth.written, srdf_form=None)
    return list(check_file(folder / "robot.srdf", written, quick=False))
