"""Completes the attributes of MJCF elements by the defaults of their classes."""

from collections.abc import Mapping

from linkwright.stages.formats.xml import Element

_SHORTHANDS = frozenset(
    ("motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion", "dcmotor")
)
"""Elements that are shorthands for <general>. A class has a single set of defaults for all of these and
<general>: MuJoCo applies those of <motor> to a <position>, too."""


class Defaults:
    """The defaults of a document, by class and tag."""

    def __init__(self, root: Element) -> None:
        self._by_class: dict[str, dict[str, dict[str, str]]] = {}
        for default in root.iterfind("default"):
            self._read(default, {}, "main")

    def attributes(self, element: Element) -> Mapping[str, str]:
        """Returns the attributes of an element: its own, and for the others the defaults of its class."""
        name = element.get("class") or self._childclass(element) or "main"
        by_tag = self._by_class.get(name) or self._by_class.get("main", {})
        return {**by_tag.get(_default_tag(element), {}), **element.attrib}

    def _childclass(self, element: Element) -> str:
        """Returns the class that the nearest enclosing body gives to its elements; "" without such a body."""
        for above in element.iterancestors():
            if above.get("childclass"):
                return str(above.get("childclass"))
        return ""

    def _read(self, default: Element, above: dict[str, dict[str, str]], fallback: str) -> None:
        """Reads a <default> and those in it. `above`: the defaults of the enclosing class, by tag;
        `fallback`: the name of a class that has none."""
        name = default.get("class") or fallback
        by_tag = {tag: dict(values) for tag, values in self._by_class.get(name, above).items()}
        for child in default:
            if child.tag != "default":
                tag = _default_tag(child)
                by_tag[tag] = {**by_tag.get(tag, {}), **child.attrib}
        self._by_class[name] = by_tag
        for child in default.iterfind("default"):
            self._read(child, by_tag, "")


def _default_tag(element: Element) -> str:
    """Returns the tag under which the defaults of an element are kept."""
    tag = str(element.tag)
    return "general" if tag in _SHORTHANDS else tag
