"""The source `mjcf`: an MJCF, MuJoCo's own format, as MuJoCo compiles it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from linkwright.stages.fetch.robot_file import RobotFileSource
from linkwright.stages.fetch.source import FetchContext, Fetched

if TYPE_CHECKING:
    from linkwright.stages.fetch.mjcf.section import MjcfSourceSection


class MjcfSource(RobotFileSource):
    """An MJCF file."""

    wanted: ClassVar[str] = "an MJCF is a file"
    example: ClassVar[str] = "robots/arm.xml"

    _keys: MjcfSourceSection

    def pinned(self, environ: Mapping[str, str]) -> dict[str, Any]:
        # Late: an unchanged source is not read again.
        from linkwright.stages.fetch.mjcf.gather import identity

        return identity(self._keys)

    def fetch(self, context: FetchContext) -> Fetched:
        # Late: an unchanged source is not read again.
        from linkwright.stages.fetch.mjcf.gather import gather

        bundle, found = gather(self._keys, context.while_waiting)
        return Fetched(bundle, diagnostics=found)
