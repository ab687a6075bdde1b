"""Browsers for the tests, one for the whole run where its flags are the usual ones."""

from functools import partial

import pytest

from linkwright.stages.show.live.viewer import view
from tests.browser.webdriver import Browser, missing

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>A robot</title><style>* {{ box-sizing: border-box }} body {{ margin: 1rem }}
{style}</style></head><body>
{body}
{scripts}
</body></html>
"""

SIZE = (900, 600)

PREVIEW = '<img class="preview" alt="preview" src="data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA=">'


@pytest.fixture(scope="session", autouse=True)
def _installed():
    if missing():
        pytest.skip(f"tests of the page need a browser: {missing()} not found on PATH")


@pytest.fixture(scope="session")
def shared_browser(_installed):
    with Browser(ratio=0.5) as browser:
        yield browser


@pytest.fixture(scope="module", autouse=True)
def _no_page_is_left(shared_browser):
    """A robot that runs is drawn for as long as its page is open, which takes a core from all later tests."""
    yield
    shared_browser.leave()


@pytest.fixture
def browser(shared_browser):
    """A browser with a small page of few pixels, which is drawn in less time; its logs are empty."""
    shared_browser.size(*SIZE)
    shared_browser.console()
    list(shared_browser.requests())
    return shared_browser


@pytest.fixture
def page_of(tmp_path):
    """Writes a page around the view of a pack."""
    return partial(write_page, tmp_path)


def write_page(folder, pack, engine="whole", shared_path=""):
    """A page around the view of a pack, in a folder."""
    page = view(pack, engine, shared_path)
    body = page.body.replace("<!-- preview -->", PREVIEW)
    path = folder / "page.html"
    path.write_text(PAGE.format(style=page.style, body=body, scripts=page.scripts), encoding="utf-8")
    return path
