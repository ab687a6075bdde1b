"""Finds the lines of elements in the files of a folder."""

import re
from pathlib import Path
from typing import Any

from linkwright.stages.formats.mjcf.bounds import MAX_XML_BYTES
from linkwright.stages.formats.xml import Malformed, parse
from linkwright.stages.robot.system.regular_files import FileTooLarge, content

_LABEL = re.compile(r'(?P<tag>[\w:.-]+)(?: "(?P<name>.*)")?')
"""Pattern of an element in a finding: its tag, and its name."""

_XML_ENDINGS = (".urdf", ".xml", ".sdf", ".srdf")
_PRIM_START = re.compile(r'^\s*(?:def|over)\b[^"\n]*"([^"\n]+)"', re.MULTILINE)
"""The start of a prim in a USD text file."""

_OTHER_TAGS = {"body": ("link",), "link": ("body",), "geom": ("collision", "visual")}
"""Tag → tags of other formats for the same element."""


class ElementLines:
    """Finds elements in the files below `folder`; each file is read once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._read: dict[str, dict[tuple[str, str], Any]] = {}

    def of(self, file: str, element: str, attribute: str = "") -> int | None:
        """Returns the line, from 1, of the element that a finding names, or of its child that has the
        attribute ("limit lower"); None if it is not found."""
        label = _LABEL.fullmatch(element)
        if label is None:
            return None
        if Path(file).suffix == ".usda":
            return self._prim_lines(file).get(("def", label["name"] or ""))
        nodes = self._element_nodes(file)
        tag, name = label["tag"], label["name"] or ""
        node = next(
            (nodes[kind, name] for kind in (tag, *_OTHER_TAGS.get(tag, ())) if (kind, name) in nodes), None
        )
        if node is None:
            return None
        # "limit lower" means the attribute `lower` of the child `limit`.
        for child_tag in attribute.split()[:1]:
            child = next((child for child in node.iterdescendants() if child.tag == child_tag), None)
            node = node if child is None else child
        return int(node.sourceline) if node.sourceline else None

    def _element_nodes(self, file: str) -> dict[tuple[str, str], Any]:
        """Maps (tag, name) to the first such element of an XML file, (tag, "") to the first of the tag. An
        element that names two links or bodies is found by both names."""
        if file not in self._read:
            nodes: dict[tuple[str, str], Any] = {}
            root = self._root(file) if Path(file).suffix in _XML_ENDINGS else None
            for node in root.iter() if root is not None else ():
                if isinstance(node.tag, str):
                    # `exclude` and `disable_collisions` name a pair in place of a name of their own.
                    keys = ("link1", "link2") if node.get("link1") else ("body1", "body2")
                    pair = '" "'.join(node.get(key, "") for key in keys)
                    for name in (node.get("name") or pair, ""):
                        nodes.setdefault((node.tag, name), node)
            self._read[file] = nodes
        return self._read[file]

    def _prim_lines(self, file: str) -> dict[tuple[str, str], int]:
        """Maps ("def", name) to the line of each prim in a USD text file."""
        if file not in self._read:
            data = self._data(file)
            text = "" if data is None else data.decode(errors="replace")
            lines: dict[tuple[str, str], Any] = {}
            for prim in _PRIM_START.finditer(text):
                lines.setdefault(("def", prim[1]), text.count("\n", 0, prim.start(1)) + 1)
            self._read[file] = lines
        return self._read[file]

    def _root(self, file: str) -> Any:
        """Returns the root element of an XML file; None if it cannot be read."""
        data = self._data(file)
        try:
            return None if data is None else parse(data, large=True)
        except (Malformed, ValueError):
            return None

    def _data(self, file: str) -> bytes | None:
        try:
            return content(self.folder / file, MAX_XML_BYTES)
        except (OSError, FileTooLarge):
            return None
