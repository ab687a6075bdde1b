"""Replaces each <include> by the content of its file, as MuJoCo does."""

from collections.abc import Callable, Sequence

from linkwright.stages.formats.xml import Element


def replace_include(include: Element, content: Sequence[Element]) -> None:
    """Replaces an <include>, which has a parent, by the elements of `content`."""
    parent = include.getparent()
    index = parent.index(include)
    parent[index : index + 1] = list(content)


def replace_includes(root: Element, read: Callable[[Element], Element | None]) -> None:
    """Replaces all includes of a document, and those of the included files. `read`: returns the root of the
    file that an <include> names, or None to include nothing. It must refuse a circle of files, which would
    never end."""
    queue = list(root.iter("include"))
    while queue:
        include = queue.pop(0)
        # The root of a document cannot be replaced.
        if include.getparent() is None:
            continue
        included = read(include)
        queue += [] if included is None else included.iter("include")
        replace_include(include, [] if included is None else list(included))
