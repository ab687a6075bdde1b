"""The site builds without a warning, has no dead link, loads nothing from elsewhere, and all can read it."""

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.browser.webdriver import Browser, missing
from tests.browser.words import complaints
from tests.docs.crawler import crawled, dead_links, file_of, outer_loads
from tests.support.places import PROJECT

pytestmark = [pytest.mark.slow, pytest.mark.e2e]

NARROW = 400
"""px, of a phone."""

AXE = "const found = await axe.run(document, {resultTypes: ['violations']}); return found.violations"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, built by its command."""
    if not find_spec("zensical"):
        pytest.skip("the site needs the dependency group docs: pip install --group docs")
    folder = tmp_path_factory.mktemp("docs")
    environ = {name: value for name, value in os.environ.items() if name != "LINKWRIGHT_PAGE"}
    command = [sys.executable, "-m", "docs.site", str(folder / "built")]
    done = subprocess.run(command, cwd=PROJECT, env=environ, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return Path(done.stdout.strip()).parent


@pytest.fixture(scope="module")
def pages(site):
    return crawled(site)


@pytest.fixture(scope="module")
def browser():
    if missing():
        pytest.skip(f"{missing()} not found on PATH")
    with Browser(ratio=0.5) as browser:
        yield browser


@pytest.fixture
def documents(pages):
    """The paths of the pages that are not those of robots."""
    return [path for path in pages if path.name != "report.html"]


def test_no_link_is_dead(pages):
    assert sorted(dead_links(pages)) == []


def test_nothing_is_loaded_from_elsewhere(pages, site):
    assert sorted(outer_loads(pages, site)) == []


def test_each_page_has_a_title_of_its_own(pages, documents):
    titles = [pages[path].title for path in documents]
    assert all(titles)
    assert sorted(titles) == sorted(set(titles))


def test_each_page_is_reached_from_the_first(pages, site, documents):
    reached, new = set(), {site / "index.html"}
    while new:
        reached |= new
        addresses = {address for path in new if path in pages for address in pages[path].links}
        new = {file_of(address)[0] for address in addresses} & {*pages} - reached
    assert {path for path in documents if path not in reached} == set()


def test_each_page_opens_without_a_complaint_or_a_request_to_elsewhere(browser, documents, site):
    for path in documents:
        browser.open(path)
        addresses = {address for address in browser.requests() if not address.startswith(("about:", "blob:"))}
        assert {a for a in addresses if not a.startswith(site.as_uri())} == set(), path
        assert complaints(browser) == [], path


def test_axe_finds_nothing_serious(browser, documents):
    if not find_spec("axe_core_python"):
        pytest.skip("axe needs the dependency group docs")
    axe = Path(find_spec("axe_core_python").origin).with_name("axe.min.js").read_text(encoding="utf-8")
    problems = set()
    for dark in (False, True):
        browser.size(1280, 900, dark=dark)
        for path in documents:
            browser.open(path)
            for rule in browser.run(f"{axe}; {AXE}"):
                if rule["impact"] in ("serious", "critical"):
                    problems.add((path.name, dark, rule["id"], rule["nodes"][0]["html"][:120]))
    assert problems == set()


def test_a_phone_shows_each_page_without_scrolling_sideways(browser, documents):
    browser.size(NARROW, 800)
    widths = {}
    for path in documents:
        browser.open(path)
        widths[path.name] = browser.run("return document.documentElement.scrollWidth")
    assert {name: width for name, width in widths.items() if width > NARROW} == {}


def test_the_search_works_from_disk(browser, site):
    browser.size(1280, 900)
    browser.open(site / "index.html")
    browser.run(
        "document.querySelector('.md-search__button').click();"
        "const focus = (e) => e?.shadowRoot ? focus(e.shadowRoot.activeElement) : e;"
        "for (let i = 0; i < 100 && focus(document.activeElement)?.tagName !== 'INPUT'; i++)"
        "  await new Promise((r) => setTimeout(r, 100));"
    )
    browser.keys("C-FALSE-CONTACT")
    # Hits of the first letters are shown while the others are typed.
    shown = browser.run(
        "let hits = [];"
        "const hosts = () => [...document.querySelectorAll('*')].filter((e) => e.shadowRoot);"
        "for (let i = 0; i < 300; i++) {"
        "  const links = hosts().flatMap((e) => [...e.shadowRoot.querySelectorAll('a[href]')]);"
        "  hits = links.map((hit) => hit.href);"
        "  if (hits.some((address) => address.includes('checks.html'))) break;"
        "  await new Promise((r) => setTimeout(r, 100));"
        "} return hits"
    )
    assert any("checks.html" in address for address in shown), shown


def test_a_robot_starts_where_its_picture_was(browser, site):
    browser.size(1280, 900)
    browser.open(site / "gallery.html")
    list(browser.requests())
    browser.run(
        "document.querySelector('.live-start').click(); await new Promise((r) => setTimeout(r, 3000))"
    )
    loaded = {address.partition("#")[0] for address in browser.requests()}
    robots = (site / "robots").as_uri()
    assert {f"{robots}/sample/report.html", f"{robots}/linkwright-engine.js"} <= loaded
    assert browser.run("return document.querySelectorAll('iframe.live-frame[title]').length") == 1
    browser.leave()
