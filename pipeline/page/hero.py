"""The robot at the top of its page: the live view, else its picture."""

from base64 import b64encode
from urllib.parse import quote

from linkwright.pipeline.page.html.markup import text
from linkwright.pipeline.show.live import Live
from linkwright.pipeline.show.preview import Preview
from linkwright.stages.show.live.viewer import LiveView, view

_SLOT = "<!-- preview -->"


def hero(live: Live, pictures: Preview, name: str) -> LiveView:
    """The view, with the small picture in it for who has no scripts and for paper; without a view the
    picture, as a link to the file of the large."""
    picture = _picture(pictures, name)
    if live.pack is None:
        linked = f'<p class="preview"><a href="{quote(pictures.path)}">{picture}</a></p>'
        return LiveView("", linked if picture else "", "")
    made = view(live.pack, live.engine, live.engine_path)
    return LiveView(made.style, made.body.replace(_SLOT, picture), made.scripts)


def _picture(pictures: Preview, name: str) -> str:
    """The small picture, which is in the page wherever that is sent."""
    if not pictures.path:
        return ""
    source = f"data:image/png;base64,{b64encode(pictures.small).decode()}"
    return f'<img src="{source}" alt="The robot {text(name)}">'
