"""Inserts the live view at the top of a page.

The view makes up most of a page's bytes, and is inserted last so that the rest can be cached. This module
imports no template, so that an unchanged build can insert its view into the cached page quickly.
"""

from linkwright.pipeline.show.live import NOTHING, Live
from linkwright.stages.show.live.viewer import view

PLACEHOLDERS = ("style", "before the picture", "after the picture", "scripts")
"""The placeholders of the view in a page, from top to bottom."""

_PICTURE = "<!-- preview -->"


def with_view(page: str, live: Live = NOTHING) -> bytes:
    """Returns a page with the live view inserted. On paper and without scripts the page shows a picture."""
    live_view = view(live.pack, live.engine, live.engine_path)
    before, _, after = live_view.body.partition(_PICTURE)
    for place, html in zip(PLACEHOLDERS, (live_view.style, before, after, live_view.scripts), strict=True):
        page = page.replace(f"<!-- view: {place} -->", html, 1)
    return page.encode()
