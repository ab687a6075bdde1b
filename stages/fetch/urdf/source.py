"""Defines the source `urdf`: a URDF, or a xacro file that makes one, and the meshes that it names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from linkwright.stages.fetch.robot_file import RobotFileSource
from linkwright.stages.fetch.source import FetchContext, Fetched
from linkwright.stages.fetch.urdf import expand, srdf_file
from linkwright.stages.fetch.urdf.survey import identity
from linkwright.stages.robot.errors import ConfigError

if TYPE_CHECKING:
    from linkwright.stages.fetch.urdf.section import UrdfSourceSection


class UrdfSource(RobotFileSource):
    """A source that is a URDF or xacro file."""

    description: ClassVar[str] = "a URDF is a file"
    example: ClassVar[str] = "robots/arm.urdf"

    _keys: UrdfSourceSection

    def preflight(self, environ: Mapping[str, str]) -> None:
        super().preflight(environ)
        for name, folder in self._keys.packages.items():
            if not Path(folder).is_dir():
                hint = "name the folder of the package, which contains folders such as meshes/"
                raise ConfigError(f"{folder} is not a folder", f"source.packages.{name}", hint)
        expand.require(self._keys)
        srdf_file.require(self._keys)

    def pinned(self, environ: Mapping[str, str]) -> dict[str, Any]:
        return identity(self._keys, environ)

    def fetch(self, context: FetchContext) -> Fetched:
        # Late: an unchanged source is not read again.
        from linkwright.stages.fetch.urdf.gather import gather

        bundle, diagnostics = gather(self._keys, context.environ)
        return Fetched(bundle, diagnostics=diagnostics)
