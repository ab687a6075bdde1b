"""Lists the checks of files that no engine reads. The readers of SDF and USD are imported only if their files
exist: that of USD takes 0.3 s."""

from collections.abc import Iterable
from pathlib import Path

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check
from linkwright.stages.validate.rows import FormatCheck
from linkwright.stages.validate.srdf.read_back import check_file as check_srdf


def _check_sdf(path: Path, written: Written, quick: bool) -> Iterable[Check]:
    # Late: only builds with an SDF need its reader.
    from linkwright.stages.validate.read.sdf import check_file

    return check_file(path, written, quick=quick)


def _check_usd(path: Path, written: Written, quick: bool) -> Iterable[Check]:
    # Late: this imports pxr.
    from linkwright.stages.validate.read.usd import check_file

    return check_file(path, written, quick=quick)


def _check_srdf(path: Path, written: Written, quick: bool) -> Iterable[Check]:
    # A `FormatCheck` passes `quick` by position, which `check_srdf` takes only by name.
    return check_srdf(path, written, quick=quick)


FORMAT_CHECKS: tuple[FormatCheck, ...] = (
    FormatCheck("C-SRDF", ".srdf", _check_srdf),
    FormatCheck("C-SDF", ".sdf", _check_sdf),
    FormatCheck("C-USD", ".usda", _check_usd),
)
"""The checks by format, in the order of the report."""
