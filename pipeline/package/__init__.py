"""Builds robots from Python: `linkwright.build("robot=my_arm")`.

Importing it loads nothing else: each name is loaded when it is first used, since most of them bring libraries
that take time to import.
"""

import sys

if sys.argv[:1] == ["-m"]:
    from . import own_path

    if own_path.is_command():
        own_path.leave_out_working_folder()

TYPE_CHECKING = False
"""Type checkers take this for true; `typing` is not imported, so that the command begins at once."""

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
    from linkwright.stages.robot.check import Check, Finding
    from linkwright.stages.robot.model.robot import Dof, Frame, Joint, Link
    from linkwright.stages.validate.compiled import CompiledModel

    __version__: str

__all__ = [
    "AssemblyError",
    "AuthError",
    "Build",
    "CacheError",
    "Check",
    "CompiledModel",
    "ConfigError",
    "DecompositionFailed",
    "Diagnostic",
    "Disconnected",
    "Dof",
    "EmptyMesh",
    "ExportError",
    "Finding",
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
    "CompiledModel": "linkwright.stages.validate.compiled",
    "Dof": "linkwright.stages.robot.model.robot",
    "Finding": "linkwright.stages.robot.check",
    "Frame": "linkwright.stages.robot.model.robot",
    "Joint": "linkwright.stages.robot.model.robot",
    "Link": "linkwright.stages.robot.model.robot",
    "Report": "linkwright.pipeline.report",
    "Robot": "linkwright.pipeline.api.robot",
}
"""The modules of the names that are not errors."""

if not TYPE_CHECKING:  # a type checker would believe in any name at all

    def __getattr__(name: str) -> object:
        if name == "__version__":
            # Late: the package has only the names that users see.
            from importlib.metadata import version

            return version("linkwright")
        if name not in __all__:
            msg = f"module 'linkwright' has no attribute {name!r}"
            raise AttributeError(msg)
        # Late: the package has only the names that users see.
        from importlib import import_module

        module = import_module(_PLACES.get(name, "linkwright.pipeline.errors"))
        globals()[name] = value = getattr(module, name)
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
