"""The public face for notebooks and scripts: all that `import linkwright` offers.

Each name is loaded when it is first used, since most of them bring libraries that take time to import.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from linkwright.pipeline.api.building import Build, build
    from linkwright.pipeline.api.robot import Robot
    from linkwright.pipeline.errors import (
        AssemblyError,
        AuthError,
        CacheError,
        ConfigError,
        DecompositionFailed,
        Diagnostic,
        Disconnected,
        EmptyMesh,
        ExportError,
        InTheWay,
        LinkwrightError,
        MeshError,
        MissingMass,
        NoRoot,
        NotFound,
        Offline,
        OutputError,
        ProtocolError,
        QuotaExhausted,
        RateLimited,
        SecretFound,
        SourceError,
        ValidationFailed,
    )
    from linkwright.pipeline.report import Report
    from linkwright.stages.robot.check import Check
    from linkwright.stages.robot.model import Dof, Frame, Joint, Link

    __version__: str

__all__ = [
    "AssemblyError",
    "AuthError",
    "Build",
    "CacheError",
    "Check",
    "ConfigError",
    "DecompositionFailed",
    "Diagnostic",
    "Disconnected",
    "Dof",
    "EmptyMesh",
    "ExportError",
    "Frame",
    "InTheWay",
    "Joint",
    "Link",
    "LinkwrightError",
    "MeshError",
    "MissingMass",
    "NoRoot",
    "NotFound",
    "Offline",
    "OutputError",
    "ProtocolError",
    "QuotaExhausted",
    "RateLimited",
    "Report",
    "Robot",
    "SecretFound",
    "SourceError",
    "ValidationFailed",
    "__version__",
    "build",
]

_PLACES = {
    "Build": "linkwright.pipeline.api.building",
    "build": "linkwright.pipeline.api.building",
    "Check": "linkwright.stages.robot.check",
    "Dof": "linkwright.stages.robot.model",
    "Frame": "linkwright.stages.robot.model",
    "Joint": "linkwright.stages.robot.model",
    "Link": "linkwright.stages.robot.model",
    "Report": "linkwright.pipeline.report",
    "Robot": "linkwright.pipeline.api.robot",
}
"""The modules of the names that are not errors."""

if not TYPE_CHECKING:  # a type checker would believe in any name at all

    def __getattr__(name: str) -> Any:
        if name == "__version__":
            from importlib.metadata import version

            return version("linkwright")
        if name not in __all__:
            msg = f"module 'linkwright' has no attribute {name!r}"
            raise AttributeError(msg)
        return getattr(import_module(_PLACES.get(name, "linkwright.pipeline.errors")), name)
