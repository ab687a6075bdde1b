"""Makes warnings failures for `validate.level: strict`."""

from collections.abc import Iterable

from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import Diagnostic


def strict_checks(
    level: str, diagnostics: Iterable[Diagnostic], checks: Iterable[Check]
) -> tuple[Check, ...]:
    """Returns the check that no stage and no check had a warning, if the level is `strict`; else nothing."""
    if level != "strict":
        return ()
    warnings = [diagnostic.code for diagnostic in diagnostics if diagnostic.level == "warning"]
    warnings += [check.code for check in checks if check.warns]
    codes = ", ".join(sorted({*warnings}))
    detail = f"{len(warnings)} warnings ({codes})" if warnings else "no warning"
    return (Check("no_warnings", not warnings, detail, float(len(warnings)), 0.0, "C-STRICT"),)
