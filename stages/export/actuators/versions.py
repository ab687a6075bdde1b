"""What newer MuJoCos have: types and parameters of actuators that the installed one may lack."""

import importlib.metadata
import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from linkwright.stages.robot.errors import ConfigError, Diagnostic

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.actuator_section import ActuatorSection

TYPES: Mapping[str, str] = {"dcmotor": "3.7", "pid": "3.12"}
"""Type → the first MuJoCo that has it."""

PARAMETERS: Mapping[str, str] = {"delay": "3.5"}
"""Parameter → the first MuJoCo that has it."""

BOTH = ("ki", "slewmax"), "3.17"
"""Parameters that one actuator may have together, and from which MuJoCo on."""


def require(entries: "Mapping[str, ActuatorSection]") -> None:
    """ConfigError where an entry of `actuators` needs a newer MuJoCo than the installed one."""
    if not entries:
        return
    installed = importlib.metadata.version("mujoco")
    problems = [
        Diagnostic(
            "E-ACTUATOR",
            f"{what} needs MuJoCo {first}; installed is {installed}",
            f"actuators.{glob}",
            f'pip install "mujoco>={first}"',
        )
        for glob, keys in entries.items()
        for what, first in _needs(keys)
        if _number(installed) < _number(first)
    ]
    if problems:
        raise ConfigError("the installed MuJoCo is too old for these actuators", problems=problems)


def _needs(keys: "ActuatorSection") -> Iterator[tuple[str, str]]:
    if keys.type is not None and keys.type in TYPES:
        yield f"type {keys.type}", TYPES[keys.type]
    for name, first in PARAMETERS.items():
        if getattr(keys, name) is not None:
            yield name, first
    names, first = BOTH
    if all(getattr(keys, name) is not None for name in names):
        yield " with ".join(names), first


def _number(version: str) -> tuple[int, ...]:
    return tuple(int(one) for one in re.findall(r"\d+", version)[:2])
