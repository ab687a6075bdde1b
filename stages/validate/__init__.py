"""The validate stage: an engine reads the files that were written, and checks compare them with the robot.

- check_options: What a configuration asks of the checks.
- compiled: A model file as an engine compiled it: what an engine returns, and what a check works with.
- contact_errors: Where the contact of a robot with itself is not that of what is seen of it, over poses
  within its limits.
- findings: What a check says of what it does not accept: element of the file, attribute, found and expected.
- format_checks: The checks of the files that no engine reads.
- rows: The rows of the tables of checks.
- run: The run of a validation: every engine reads its files, and every check looks at what it compiled.
- section: Configuration of the validate stage: how much is checked.
- user_checks: The user's own checks: functions that are called with a compiled model, and what they find.
"""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from linkwright.stages.formats.written import Written
    from linkwright.stages.robot.check import Check
    from linkwright.stages.validate.rows import ModelCheck
    from linkwright.stages.validate.section import ValidateSections
    from linkwright.stages.validate.user_checks import OwnCheck

VERSION = 52
"""Grows with every change of what this stage makes of the same input."""


def validate(
    folder: Path, written: "Written", keys: "ValidateSections", own: "Sequence[OwnCheck]" = ()
) -> "tuple[Check, ...]":
    """The checks of every model file in `folder`; with `validate=quick` only of its text, and that it
    compiles. A check that fails does not stop the others. `own`: the user's checks."""
    # Late: the configuration reads this package and checks nothing.
    from linkwright.stages.validate.check_options import Asked, known_payload
    from linkwright.stages.validate.run import check_files, check_formats, check_texts, readiness

    checks: Sequence[ModelCheck] = ()
    if keys.validate.level != "quick":
        from linkwright.stages.validate.checks import MODEL_CHECKS  # not for quick: all checks take 0.1 s

        checks = MODEL_CHECKS
    payload = known_payload(written.robot, keys.validate.payload)
    asked = Asked(keys.validate.level == "strict", payload)
    found = list(check_texts(folder, written))
    found += check_files(folder, written, checks, own if checks else (), asked)
    found += check_formats(folder, written, quick=not checks)
    if checks:
        found += readiness(folder, written, found)
    return tuple(found)


def measured(folder: Path, robot: str, level: str) -> dict[str, float]:
    """Figures of the finished files, with `validate=strict`: the machine's as much as the robot's."""
    if level != "strict":
        return {}
    # Late: it imports MuJoCo.
    from linkwright.stages.validate.simulate.speed import steps_per_second

    speed = steps_per_second(folder, robot)
    return {} if speed is None else {"steps_per_second": speed}
