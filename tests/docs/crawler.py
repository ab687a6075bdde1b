"""Reads the pages of a site as a crawler does: links, anchors, titles, and what each page loads."""

import re
from pathlib import Path
from urllib.parse import unquote, urljoin, urlparse

from lxml import html

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
