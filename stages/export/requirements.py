"""What the installed packages must have for an export."""

import importlib.util
from collections.abc import Mapping
from typing import TYPE_CHECKING

from linkwright.stages.export.actuators import versions
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.system.install import install

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections

NEEDS: Mapping[str, tuple[str, str]] = {"usd": ("pxr", "usd-core")}
"""Format → the module that writes it, and the optional package that has that."""


def packages(keys: "ExportSections") -> tuple[str, ...]:
    """The optional packages of the formats that are chosen, whose versions may change the bytes."""
    return tuple(package for name, (_, package) in NEEDS.items() if name in keys.export.chosen)


def require(keys: "ExportSections") -> None:
    """ConfigError where the optional package of a format is not installed, or an actuator needs a newer
    MuJoCo."""
    versions.require(keys.actuators)
    for name, (module, package) in NEEDS.items():
        if name in keys.export.chosen and importlib.util.find_spec(module) is None:
            msg = f"the format {name} is written with the package {package}, which is not installed"
            raise ConfigError(msg, f"export.{name}", install(package))
