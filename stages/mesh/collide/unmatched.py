"""The message about a glob that means no link and no CAD part."""

from collections.abc import Sequence

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Link
from linkwright.stages.robot.text.globs import there_are, unnumbered


def report_unmatched(glob: str, links: Sequence[Link], where: str, log: Diagnostics) -> None:
    """E-GLOB at the key `where`, with the nearest name and all links and parts."""
    parts = {unnumbered(part.name.rpartition("/")[2]) for link in links for part in link.parts}
    hint = there_are(glob, {"links": [link.name for link in links], "parts": sorted(parts)})
    log.unmatched("E-GLOB", f"no link and no part matches {glob!r}", where, hint, glob)
