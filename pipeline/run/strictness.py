"""`validate.level: strict`: a warning is a failure."""

from collections.abc import Iterable

from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import Diagnostic


def strict_checks(level: str, found: Iterable[Diagnostic], checks: Iterable[Check]) -> tuple[Check, ...]:
    """With the level `strict` a check that there was no warning, of a stage or of a check; else none."""
    if level != "strict":
        return ()
    warnings = [one.code for one in found if one.level == "warning"]
    warnings += [check.code for check in checks if check.warns]
    codes = ", ".join(sorted({*warnings}))
    detail = f"{len(warnings)} warnings ({codes})" if warnings else "no warning"
    return (Check("no_warnings", not warnings, detail, float(len(warnings)), 0.0, "C-STRICT"),)
