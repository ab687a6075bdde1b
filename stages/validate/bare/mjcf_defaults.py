"""The attributes of MJCF elements with what their classes give them."""

from collections.abc import Mapping

from linkwright.stages.formats.xml import Element

_SHORT = frozenset(
    ("motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion", "dcmotor")
)
"""Actuators that are short for <general>, whose defaults apply to them where they have none of their own."""


class Defaults:
    """The defaults of a document, by class and tag."""

    def __init__(self, root: Element) -> None:
        self._by_class: dict[str, dict[str, dict[str, str]]] = {}
        for default in root.iterfind("default"):
            self._read(default, {}, "main")

    def attributes(self, element: Element) -> Mapping[str, str]:
        """The attributes of an element, its own before those of its class."""
        name = element.get("class") or self._childclass(element) or "main"
        given = self._by_class.get(name) or self._by_class.get("main", {})
        tag = str(element.tag)
        below = given.get(tag) or (given.get("general", {}) if tag in _SHORT else {})
        return {**below, **element.attrib}

    def _childclass(self, element: Element) -> str:
        for above in element.iterancestors():
            if above.get("childclass"):
                return str(above.get("childclass"))
        return ""

    def _read(self, default: Element, above: dict[str, dict[str, str]], fallback: str) -> None:
        name = default.get("class") or fallback
        own = {tag: dict(values) for tag, values in self._by_class.get(name, above).items()}
        for child in default:
            if child.tag != "default":
                own[str(child.tag)] = {**own.get(str(child.tag), {}), **child.attrib}
        self._by_class[name] = own
        for child in default.iterfind("default"):
            self._read(child, own, "")
