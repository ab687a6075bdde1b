"""Checkers of other makers, run on a copy of what was written: an opinion that is not ours.

`TOOLS`: the name in `validate.external` → the tool.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.validate.external.tool import Tool

if TYPE_CHECKING:
    from linkwright.stages.robot.check import Check

CODE = "C-EXTERNAL"

TOOLS = {
    "simcheck": Tool("simcheck", "simcheck", "simcheck", "simcheck"),
    "mjcf_doctor": Tool("mjcf_doctor", "mjcf-doctor", "mjcf-doctor", "mjcf_doctor"),
    "urdf_validator": Tool(
        "urdf_validator", "urdf_validate", "urdf-validator", "urdf_validator_main", "urdf_validator_main.cli"
    ),
}
"""The checkers that are known."""


def require(names: Sequence[str], environ: Mapping[str, str]) -> None:
    """ConfigError for a checker that is asked for and is not installed."""
    absent = [TOOLS[name] for name in names if TOOLS[name].command(environ) is None]
    if absent:
        commands = " and ".join(one.program for one in absent)
        packages = " ".join(one.package for one in absent)
        msg = f"{commands} {'is' if len(absent) == 1 else 'are'} not installed"
        hint = f"pip install {packages}, here or where PATH leads; or take it out of validate.external"
        raise ConfigError(msg, "validate.external", hint)


def versions(names: Sequence[str], environ: Mapping[str, str]) -> dict[str, str]:
    """The version of each checker: another one may say something else."""
    return {name: TOOLS[name].version(environ) for name in names}


def gave_no_verdict(check: "Check") -> bool:
    """Whether a checker failed, and not the robot: such a result is not kept."""
    return check.code == CODE and not check.passed and not check.findings


def check_externally(
    folder: Path, robot: str, names: Sequence[str], environ: Mapping[str, str]
) -> "tuple[Check, ...]":
    """The verdict of each checker on each file in `folder` that it reads; `robot` is the robot's name."""
    if not names:
        return ()
    # Late: most builds ask no other checker.
    from linkwright.stages.validate.external.run import checks

    return tuple(checks(folder, robot, [TOOLS[name] for name in names], environ))
