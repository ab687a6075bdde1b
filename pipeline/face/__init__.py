"""The public face for notebooks and scripts: all that `import linkwright` offers.

Each name is loaded when it is first used, since most of them bring libraries that take time to import.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pipeline.errors import (
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
    from pipeline.face.building import Build, build
    from pipeline.face.robot import Robot
    from pipeline.report import Report
    from stages.robot.check import Check
    from stages.robot.model import Dof, Frame, Joint, Link

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
    "Build": "pipeline.face.building",
    "build": "pipeline.face.building",
    "Check": "stages.robot.check",
    "Dof": "stages.robot.model",
    "Frame": "stages.robot.model",
    "Joint": "stages.robot.model",
    "Link": "stages.robot.model",
    "Report": "pipeline.report",
    "Robot": "pipeline.face.robot",
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
        return getattr(import_module(_PLACES.get(name, "pipeline.errors")), name)
