"""What the checks say of the SRDF in a folder, against its robot.json alone."""

from dataclasses import replace

from linkwright.stages.formats.described import described
from linkwright.stages.validate.srdf.read_back import check_file


def srdf_checks(folder):
    """The checks of `robot.srdf`."""
    truth = described((folder / "robot.json").read_bytes())
    written = replace(truth.written, srdf_form=None)
    return list(check_file(folder / "robot.srdf", written, quick=False))
