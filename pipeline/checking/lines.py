"""The lines of elements in the files of a folder."""

import re
from pathlib import Path
from typing import Any

from linkwright.stages.formats.mjcf.bounds import LARGEST_TEXT
from linkwright.stages.formats.xml import Malformed, parse
from linkwright.stages.robot.system.regular_files import FileTooLarge, content

_LABEL = re.compile(r'(?P<tag>[\w:.-]+)(?: "(?P<name>.*)")?')
"""How a finding names an element: its tag, and its name."""

_XML = (".urdf", ".xml", ".sdf", ".srdf")
_PRIM = re.compile(r'^\s*(?:def|over)\b[^"\n]*"([^"\n]+)"', re.MULTILINE)
"""What begins a prim of a USD in text."""

_ALSO = {"body": ("link",), "link": ("body",), "geom": ("collision", "visual")}
"""Tag → those that another format has for it."""


class ElementLines:
    """Finds elements in the files below `folder`; each file is read once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._read: dict[str, dict[tuple[str, str], Any]] = {}

    def of(self, file: str, element: str, attribute: str = "") -> int | None:
        """The line, from 1, of the element that a finding names, or of the one in it that has the attribute
        ("limit lower"); None where it is not found."""
        label = _LABEL.fullmatch(element)
        if label is None:
            return None
        if Path(file).suffix == ".usda":
            return self._of_prims(file).get(("def", label["name"] or ""))
        known = self._of_elements(file)
        tag, name = label["tag"], label["name"] or ""
        node = next((known[one, name] for one in (tag, *_ALSO.get(tag, ())) if (one, name) in known), None)
        if node is None:
            return None
        for inner in attribute.split()[:1]:
            found = next((one for one in node.iterdescendants() if one.tag == inner), None)
            node = node if found is None else found
        return int(node.sourceline) if node.sourceline else None

    def _of_elements(self, file: str) -> dict[tuple[str, str], Any]:
        """By tag and name, and by tag alone, the first such element of an XML file."""
        if file not in self._read:
            found: dict[tuple[str, str], Any] = {}
            root = self._root(file) if Path(file).suffix in _XML else None
            for node in root.iter() if root is not None else ():
                if isinstance(node.tag, str):
                    keys = ("link1", "link2") if node.get("link1") else ("body1", "body2")
                    pair = '" "'.join(node.get(key, "") for key in keys)
                    for name in (node.get("name") or pair, ""):
                        found.setdefault((node.tag, name), node)
            self._read[file] = found
        return self._read[file]

    def _of_prims(self, file: str) -> dict[tuple[str, str], int]:
        """The lines of the prims of a USD, by name."""
        if file not in self._read:
            data = self._data(file)
            text = "" if data is None else data.decode(errors="replace")
            found: dict[tuple[str, str], Any] = {}
            for prim in _PRIM.finditer(text):
                found.setdefault(("def", prim[1]), text.count("\n", 0, prim.start(1)) + 1)
            self._read[file] = found
        return self._read[file]

    def _root(self, file: str) -> Any:
        data = self._data(file)
        try:
            return None if data is None else parse(data, large=True)
        except (Malformed, ValueError):
            return None

    def _data(self, file: str) -> bytes | None:
        try:
            return content(self.folder / file, LARGEST_TEXT)
        except (OSError, FileTooLarge):
            return None
