"""Defines the source `mjcf`: an MJCF, MuJoCo's own format, as MuJoCo compiles it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from linkwright.stages.fetch.mjcf.gather import gather, identity
from linkwright.stages.fetch.robot_file import RobotFileSource
from linkwright.stages.fetch.source import FetchContext, Fetched

if TYPE_CHECKING:
    from linkwright.stages.fetch.mjcf.section import MjcfSourceSection


class MjcfSource(RobotFileSource):
    """A source that is an MJCF file."""

    description: ClassVar[str] = "an MJCF is a file"
    example: ClassVar[str] = "robots/arm.xml"

    _keys: MjcfSourceSection

    def pinned(self, environ: Mapping[str, str]) -> dict[str, Any]:
        return identity(self._keys)

    def fetch(self, context: FetchContext) -> Fetched:
        bundle, diagnostics = gather(self._keys, context.while_waiting)
        return Fetched(bundle, diagnostics=diagnostics)
