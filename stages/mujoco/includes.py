"""The content of included files in the place of each <include>, as MuJoCo has it."""

from collections.abc import Callable, Sequence

from linkwright.stages.formats.xml import Element


def put_in_place(include: Element, content: Sequence[Element]) -> None:
    """Puts elements in the place of an <include>."""
    above = include.getparent()
    place = above.index(include)
    above[place : place + 1] = list(content)


def resolve(root: Element, read: Callable[[Element], Element | None]) -> None:
    """Resolves all includes of a document, and those of what they include, in place. `read`: the root of the
    file that an <include> names, None for one of which nothing is included."""
    waiting = list(root.iter("include"))
    while waiting:
        include = waiting.pop(0)
        if include.getparent() is None:
            continue
        other = read(include)
        waiting += [] if other is None else other.iter("include")
        put_in_place(include, [] if other is None else list(other))
