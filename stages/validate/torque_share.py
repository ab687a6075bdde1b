"""Runs only the torque check, for files that need not be those of a build."""

from pathlib import Path

from linkwright.stages.formats.written import Written
from linkwright.stages.validate.check_options import CheckOptions
from linkwright.stages.validate.checks import MODEL_CHECKS
from linkwright.stages.validate.run import check_files
from linkwright.stages.validate.torque_value import CODE, torque_value


def torque_share(folder: Path, written: Written, options: CheckOptions) -> float | None:
    """Returns `torque_value` of the files in `folder`; also None if the MJCF does not compile."""
    rows = [row for row in MODEL_CHECKS if row.code == CODE]
    return torque_value(check_files(folder, written, rows, options=options))
