"""Checks that the installed packages, and the chosen formats, suffice for an export."""

import importlib.util
from collections.abc import Mapping
from typing import TYPE_CHECKING

from linkwright.stages.export.actuators import versions
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.system.install import install
from linkwright.stages.targets.engines import ENGINES

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections

OPTIONAL_PACKAGES: Mapping[str, tuple[str, str]] = {"usd": ("pxr", "usd-core")}
"""Format → the module that writes it, and the optional package with that module."""


def _require_formats(keys: "ExportSections") -> None:
    for name in keys.target.chosen:
        reads = ENGINES[name].reads
        if ENGINES[name].format(keys.export.chosen) is None:
            msg = f"{name} reads {' or '.join(reads)}, and none of them is written"
            raise ConfigError(
                msg, f"target.{name}", f"add one, as export=[{','.join([*keys.export.chosen, reads[0]])}]"
            )


def packages(keys: "ExportSections") -> tuple[str, ...]:
    """Returns the optional packages of the chosen formats. Their versions may change the bytes of the
    files."""
    return tuple(package for name, (_, package) in OPTIONAL_PACKAGES.items() if name in keys.export.chosen)


def require(keys: "ExportSections") -> None:
    """Raises ConfigError if a target reads no format that is written, if the optional package of a format is
    not installed, or if an actuator needs a newer MuJoCo."""
    _require_formats(keys)
    versions.require_versions(keys.actuators)
    for name, (module, package) in OPTIONAL_PACKAGES.items():
        if name in keys.export.chosen and importlib.util.find_spec(module) is None:
            msg = f"the format {name} is written with the package {package}, which is not installed"
            raise ConfigError(msg, f"export.{name}", install(package))
