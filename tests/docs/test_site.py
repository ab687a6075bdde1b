"""The site builds without a warning, has no dead link, loads nothing from elsewhere, and all can read it."""

import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote, urljoin, urlparse

import pytest
from lxml import html

from tests.browser.webdriver import Browser, missing
from tests.browser.words import complaints
from tests.support.places import PROJECT

pytestmark = [pytest.mark.slow, pytest.mark.e2e]

NARROW = 400
"""px, of a phone."""

AXE = "const found = await axe.run(document, {resultTypes: ['violations']}); return found.violations"


LOADS = (
    ("script", "src"), ("img", "src"), ("iframe", "src"), ("source", "src"), ("video", "src"),
    ("audio", "src"), ("embed", "src"), ("object", "data"), ("link", "href"), ("use", "href"),
    ("image", "href"),
)  # fmt: skip
"""Elements and attributes by which a page loads something."""


CSS_URL = re.compile(r"url\(\s*['\"]?([^'\")]+)|@import\s+['\"]([^'\"]+)")


class PageRead:
    """A page: its title, its anchors, where it links to, and what it loads, as absolute addresses."""

    def __init__(self, path):
        self.path = path
        text = path.read_text(encoding="utf-8")
        tree = html.fromstring(text)
        base = path.as_uri()
        self.title = (tree.findtext(".//title") or "").strip()
        self.anchors = {*tree.xpath("//@id"), *tree.xpath("//a/@name")}
        self.links = {urljoin(base, address) for address in tree.xpath("//a/@href | //area/@href")}
        loaded = [address for tag, name in LOADS for address in tree.xpath(f"//{tag}/@{name}")]
        loaded += [part.split()[0] for text in tree.xpath("//@srcset") for part in text.split(",")]
        for style in (*tree.xpath("//style/text()"), *tree.xpath("//@style")):
            loaded += css_addresses(style)
        self.loads = {urljoin(base, address) for address in loaded if not address.startswith("data:")}


def css_addresses(text):
    addresses = (first or second for first, second in CSS_URL.findall(text))
    return [address for address in addresses if not address.startswith("data:")]


def crawled(site):
    """The pages of a site by their paths."""
    return {path: PageRead(path) for path in sorted(site.rglob("*.html")) if path.name != "404.html"}


def file_of(address):
    """The file of an address on this computer, and its anchor; None for another's."""
    parsed = urlparse(address)
    return (Path(unquote(parsed.path)), parsed.fragment) if parsed.scheme == "file" else (None, "")


def dead_links(pages):
    """Each link of a page to a file or to an anchor that is not there."""
    for path, page in pages.items():
        for address in page.links | page.loads:
            file, anchor = file_of(address)
            if file is None:
                continue
            if not file.is_file() or (
                anchor and file in pages and unquote(anchor) not in pages[file].anchors
            ):
                yield f"{path.name} → {address}"


def outer_loads(pages, site):
    """Each address that a page or a style sheet loads and that is not a file of the site."""
    for path, page in pages.items():
        for address in page.loads:
            file, _ = file_of(address)
            if file is None or not file.is_relative_to(site):
                yield f"{path.name} loads {address}"
    for sheet in site.rglob("*.css"):
        for address in css_addresses(sheet.read_text(encoding="utf-8")):
            file, _ = file_of(urljoin(sheet.as_uri(), address))
            if file is None or not file.is_file():
                yield f"{sheet.name} loads {address}"


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


def test_page_opens_without_complaint_or_outer_request(browser, documents, site):
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
