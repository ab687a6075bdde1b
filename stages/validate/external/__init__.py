"""Runs checkers of other makers on a copy of the written files, for an independent opinion.

`TOOLS`: the name in `validate.external` → the tool.
"""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.validate.external.tool import Tool

if TYPE_CHECKING:
    from linkwright.stages.robot.check import Check

CODE = "C-EXTERNAL"

TOOLS = {
    "simcheck": Tool("simcheck", "simcheck", ("simcheck",), ("urdf", "mjcf"), "simcheck"),
    "mjcf_doctor": Tool("mjcf_doctor", "mjcf-doctor", ("mjcf-doctor",), ("mjcf",), "mjcf_doctor"),
    "urdf_validator": Tool(
        "urdf_validator",
        "urdf_validate",
        ("urdf-validator",),
        ("urdf",),
        "urdf_validator_main",
        "urdf_validator_main.cli",
    ),
    "simready": Tool(
        "simready",
        "simready-validate",
        ("simready-validate", "simready-foundation-tier-core"),
        ("usd",),
        pythons=((3, 11), (3, 12)),
    ),
}
"""The checkers that can be run."""


def require(names: Sequence[str], formats: Sequence[str], environ: Mapping[str, str]) -> None:
    """Raises ConfigError if a checker is not installed, or reads none of the formats that are written."""
    for name in names:
        reads = TOOLS[name].reads
        if not set(reads) & set(formats):
            msg = f"{name} reads {' or '.join(reads)}, and none of them is written"
            hint = f"add a format, as export=[{','.join([*formats, reads[0]])}]"
            raise ConfigError(msg, "validate.external", hint)
    absent = [TOOLS[name] for name in names if TOOLS[name].command(environ) is None]
    if absent:
        commands = " and ".join(tool.program for tool in absent)
        packages = " ".join(package for tool in absent for package in tool.packages)
        msg = f"{commands} {'is' if len(absent) == 1 else 'are'} not installed"
        hint = f"pip install {packages}, here or where PATH leads; or take it out of validate.external"
        for tool in absent:
            if tool.pythons and sys.version_info[:2] not in tool.pythons:
                versions_needed = " or ".join(f"{major}.{minor}" for major, minor in tool.pythons)
                python_version = ".".join(map(str, sys.version_info[:2]))
                need = f"{tool.program} needs an environment of Python {versions_needed}"
                hint += f" ({need}; this is {python_version})"
        raise ConfigError(msg, "validate.external", hint)


def versions(names: Sequence[str], environ: Mapping[str, str]) -> dict[str, str]:
    """Returns the version of each checker, since another version may give other results."""
    return {name: TOOLS[name].version(environ) for name in names}


def gave_no_verdict(check: "Check") -> bool:
    """Tells whether the checker failed, and not the robot, so that the result is not kept."""
    return check.code == CODE and not check.passed and not check.findings


def check_externally(
    folder: Path, robot: str, names: Sequence[str], environ: Mapping[str, str]
) -> "tuple[Check, ...]":
    """Returns the verdict of each checker on each file in `folder` that it reads. `robot`: its name."""
    if not names:
        return ()
    # Late: most builds ask no other checker.
    from linkwright.stages.validate.external.run import run_checkers

    return tuple(run_checkers(folder, robot, [TOOLS[name] for name in names], environ))
