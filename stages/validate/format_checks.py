"""Lists the checks of files that no engine reads. A reader is imported only if its file exists: that of USD
takes 0.3 s."""

from collections.abc import Iterable
from pathlib import Path

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check
from linkwright.stages.validate.rows import FormatCheck
from linkwright.stages.validate.srdf.read_back import check_file


def _srdf(path: Path, written: Written, quick: bool) -> Iterable[Check]:
    return check_file(path, written, quick=quick)


def _sdf(path: Path, written: Written, quick: bool) -> Iterable[Check]:
    from linkwright.stages.validate.read.sdf import check_file  # read where there is an SDF

    return check_file(path, written, quick=quick)


def _usd(path: Path, written: Written, quick: bool) -> Iterable[Check]:
    from linkwright.stages.validate.read.usd import check_file  # pxr

    return check_file(path, written, quick=quick)


FORMAT_CHECKS: tuple[FormatCheck, ...] = (
    FormatCheck("C-SRDF", ".srdf", _srdf),
    FormatCheck("C-SDF", ".sdf", _sdf),
    FormatCheck("C-USD", ".usda", _usd),
)
"""The checks by format, in the order of the report."""
