"""Reads a page of HTML, and holds what is true of every page."""

from html.parser import HTMLParser
from itertools import pairwise
from typing import ClassVar


class Reader(HTMLParser):
    """Collects the text, and holds what is true of every page: each element is closed in its turn, where it
    may be; ids are unique, and links of the page lead to them; headings have an order; pictures have words,
    and the cells that head a table say of what."""

    VOID = frozenset({"meta", "br", "wbr", "img", "input", "link", "hr"})
    PARENTS: ClassVar = {
        "li": {"ul", "ol"},
        "dt": {"dl", "div"},
        "dd": {"dl", "div"},
        "tr": {"thead", "tbody"},
        "td": {"tr"},
        "th": {"tr"},
        "summary": {"details"},
        "figcaption": {"figure"},
    }
    BLOCKS: ClassVar = {"div", "section", "table", "details", "p", "ul", "ol", "pre", "h2", "h3", "svg"}

    def __init__(self, data):
        super().__init__()
        self.open, self.said, self.links, self.ids = [], [], [], []
        self.folded, self.headings, self.marks = [], [], []
        self.feed(data.decode())
        assert self.open == []
        assert len(self.ids) == len(set(self.ids))
        anchors = {target[1:] for target in self.links if target.startswith("#")}
        assert anchors <= set(self.ids), anchors - set(self.ids)
        if self.marks.count("html"):
            assert self.headings[0] == 1
            assert self.headings.count(1) == 1
            assert self.marks.count("main") == self.marks.count("header") == self.marks.count("title") == 1
        assert all(deeper - level <= 1 for level, deeper in pairwise(self.headings)), self.headings

    def handle_starttag(self, tag, attrs):
        self.links += [value for name, value in attrs if name in ("src", "href", "xlink:href", "data")]
        self.ids += [value for name, value in attrs if name == "id"]
        self.marks.append(f"svg {tag}" if "svg" in self.open else tag)
        attributes = dict(attrs)
        assert len(attributes) == len(attrs), f"an attribute twice: {tag} {attrs}"
        assert not [name for name in attributes if name.startswith("on")]
        if tag in self.PARENTS:
            assert self.open[-1] in self.PARENTS[tag], f"{tag} in {self.open}"
        if tag in self.BLOCKS:
            assert not {"p", "span", "a", "h2", "h3"} & set(self.open), f"{tag} in {self.open}"
        if tag == "img":
            assert attributes["alt"]
        if tag == "th":
            assert attributes["scope"] == ("col" if "thead" in self.open else "row")
        if tag == "html":
            assert attributes["lang"] == "en"
        if tag in ("h1", "h2", "h3", "h4"):
            self.headings.append(int(tag[1]))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] in (["script"], ["style"]):
            return
        self.said.append(data)
        if "details" in self.open and "summary" not in self.open:
            self.folded.append(data)

    @property
    def text(self):
        return "\n".join(self.said)

    def lacking(self, *words):
        """Those of these words that are not in the text."""
        return [word for word in words if word not in self.text]
