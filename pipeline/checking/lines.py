"""The lines of elements in the files of a folder."""

import re
from pathlib import Path
from typing import Any

_LABEL = re.compile(r'(?P<tag>[\w:.-]+)(?: "(?P<name>.*)")?')
"""How a finding names an element: its tag, and its name."""

_ROOTS = {".urdf": "robot", ".xml": "mujoco", ".sdf": "sdf"}
"""Ending → the tag of the root of such a file."""

_ALSO = {"body": ("link",), "link": ("body",), "geom": ("collision", "visual"), "hinge": ("joint",)}
"""Tag → those that another format has for it."""


class ElementLines:
    """Finds elements in the files below `folder`; each file is read once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._read: dict[str, dict[tuple[str, str], int]] = {}

    def of(self, file: str, element: str) -> int | None:
        """The line, from 1, of the element that a finding names; None where it is not found."""
        label = _LABEL.fullmatch(element)
        if label is None or Path(file).suffix not in _ROOTS:
            return None
        known = self._of_file(file)
        tag, name = label["tag"], label["name"] or ""
        tags = (tag, *_ALSO.get(tag, ()))
        return next((known[one, name] for one in tags if (one, name) in known), None)

    def _of_file(self, file: str) -> dict[tuple[str, str], int]:
        """By tag and name, and by tag alone, the line of the first such element."""
        if file not in self._read:
            self._read[file] = {}
            root = self._root(file)
            for node in root.iter() if root is not None else ():
                if isinstance(node.tag, str) and node.sourceline:
                    for name in (node.get("name") or "", ""):
                        self._read[file].setdefault((node.tag, name), node.sourceline)
        return self._read[file]

    def _root(self, file: str) -> Any:
        from stages.formats.xml import Malformed, parse

        try:
            return parse((self.folder / file).read_bytes(), large=True)
        except (OSError, Malformed, ValueError):
            return None
