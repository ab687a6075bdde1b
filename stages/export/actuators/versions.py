"""Refuses actuator types and parameters that the installed version of MuJoCo does not have."""

import importlib.metadata
import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from linkwright.stages.robot.errors import ConfigError, Diagnostic

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.actuator_section import ActuatorSection

FIRST_VERSION_OF_TYPE: Mapping[str, str] = {"dcmotor": "3.7", "pid": "3.12"}
"""Actuator type → the first MuJoCo version that has it."""

FIRST_VERSION_OF_PARAMETER: Mapping[str, str] = {"delay": "3.5"}
"""Parameter → the first MuJoCo version that has it."""

COMBINED_PARAMETERS = ("ki", "slewmax"), "3.17"
"""Parameters that exclude each other in older versions, and the first version that allows them together."""


def require_versions(entries: "Mapping[str, ActuatorSection]") -> None:
    """Raises ConfigError if an entry of `actuators` needs a newer MuJoCo than the installed version."""
    if not entries:
        return
    installed = importlib.metadata.version("mujoco")
    problems = [
        Diagnostic(
            "E-ACTUATOR",
            f"{feature} needs MuJoCo {first_version}; installed is {installed}",
            f"actuators.{glob}",
            f'pip install "mujoco>={first_version}"',
        )
        for glob, section in entries.items()
        for feature, first_version in _needs(section)
        if _version_tuple(installed) < _version_tuple(first_version)
    ]
    if problems:
        raise ConfigError("the installed MuJoCo is too old for these actuators", problems=problems)


def _needs(section: "ActuatorSection") -> Iterator[tuple[str, str]]:
    if section.type is not None and section.type in FIRST_VERSION_OF_TYPE:
        yield f"type {section.type}", FIRST_VERSION_OF_TYPE[section.type]
    for name, first_version in FIRST_VERSION_OF_PARAMETER.items():
        if getattr(section, name) is not None:
            yield name, first_version
    names, first_version = COMBINED_PARAMETERS
    if all(getattr(section, name) is not None for name in names):
        yield " with ".join(names), first_version


def _version_tuple(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", version)[:2])
