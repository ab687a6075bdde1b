"""The validate stage: engines read the written files, and checks compare them with the robot.

- check_options: Defines the settings by which a configuration steers the checks.
- compiled: Defines compiled models, which engines make from files and checks take as their argument.
- contact_errors: Finds contacts of a robot with itself that differ from those of its visual shapes, over
  poses within its limits.
- findings: Makes the findings of checks, which name an element, an attribute, and the actual and expected
  value.
- format_checks: Lists the checks of files that no engine reads.
- rows: Defines the rows of the tables of checks.
- run: Runs a validation: every engine reads its files, and every check judges the compiled models.
- section: Defines the configuration of the validate stage: how much is checked.
- torque_share: Runs only the torque check, for files that need not be those of a build.
- torque_value: Reads the torque check as a number: the share of a joint's strength that the robot's weight
  takes.
- user_checks: Runs the user's own checks, which are called with a compiled model, and labels their results.
"""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from linkwright.stages.formats.written import Written
    from linkwright.stages.robot.check import Check
    from linkwright.stages.validate.rows import ModelCheck
    from linkwright.stages.validate.section import ValidateSections
    from linkwright.stages.validate.user_checks import UserCheck

VERSION = 64
"""Grows with every change of this stage's results for the same input."""


def validate(
    folder: Path, written: "Written", keys: "ValidateSections", own: "Sequence[UserCheck]" = ()
) -> "tuple[Check, ...]":
    """Checks every model file in `folder`; with `validate=quick`, only its text and whether it compiles. A
    check that fails does not stop the others. `own`: the user's checks."""
    # Late: the configuration reads this package and checks nothing.
    from linkwright.stages.validate.check_options import CheckOptions, known_payload
    from linkwright.stages.validate.run import check_files, check_formats, check_texts, readiness

    checks: Sequence[ModelCheck] = ()
    if keys.validate.level != "quick":
        from linkwright.stages.validate.checks import MODEL_CHECKS  # not for quick: all checks take 0.1 s

        checks = MODEL_CHECKS
    payload = known_payload(written.robot, keys.validate.payload)
    options = CheckOptions(keys.validate.level == "strict", payload)
    results = list(check_texts(folder, written))
    results += check_files(folder, written, checks, own if checks else (), options)
    results += check_formats(folder, written, keys.target, quick=not checks)
    if checks:
        results += readiness(folder, written, results)
    return tuple(results)


def measured(folder: Path, robot: str, level: str) -> dict[str, float]:
    """Returns the figures that are measured on the finished files, with `validate=strict` only, since they
    depend on the machine as well as on the robot."""
    if level != "strict":
        return {}
    # Late: it imports MuJoCo.
    from linkwright.stages.validate.simulate.speed import steps_per_second

    speed = steps_per_second(folder, robot)
    return {} if speed is None else {"steps_per_second": speed}
