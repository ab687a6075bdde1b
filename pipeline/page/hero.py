"""The live view at the top of a page: most of its bytes, and put in last, so that the rest can be kept alone.

Imports no template: an unchanged build puts its view into the page that was kept.
"""

from linkwright.pipeline.show.live import NOTHING, Live
from linkwright.stages.show.live.viewer import view

PLACES = ("style", "before the picture", "after the picture", "scripts")
"""The places of the view in a page, in their order."""

_PICTURE = "<!-- preview -->"


def with_view(frame: str, live: Live = NOTHING) -> bytes:
    """A page with the view of a robot, which has the page's picture for who has no scripts and for paper."""
    made = view(live.pack, live.engine, live.engine_path)
    before, _, after = made.body.partition(_PICTURE)
    for place, piece in zip(PLACES, (made.style, before, after, made.scripts), strict=True):
        frame = frame.replace(f"<!-- view: {place} -->", piece, 1)
    return frame.encode()
