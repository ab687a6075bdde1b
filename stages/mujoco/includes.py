"""Replaces each <include> by the content of its file, as MuJoCo does."""

from collections.abc import Callable, Sequence

from linkwright.stages.formats.xml import Element


def replace_include(include: Element, content: Sequence[Element]) -> None:
    """Replaces an <include> by the elements of `content`."""
    parent = include.getparent()
    place = parent.index(include)
    parent[place : place + 1] = list(content)


def replace_includes(root: Element, read: Callable[[Element], Element | None]) -> None:
    """Replaces all includes of a document, and the includes of the included files. `read`: returns the root
    of the file that an <include> names, or None to include nothing."""
    queue = list(root.iter("include"))
    while queue:
        include = queue.pop(0)
        if include.getparent() is None:
            continue
        included = read(include)
        queue += [] if included is None else included.iter("include")
        replace_include(include, [] if included is None else list(included))
