"""The joints of an MJCF in the order in which MuJoCo numbers them."""

from collections.abc import Iterator

from linkwright.stages.formats.xml import Element

JOINTS = ("joint", "freejoint")

TYPES = ("hinge", "slide", "ball", "free")

HINGE = "hinge"
"""The type of a joint that says none."""


def joints_in_order(root: Element) -> Iterator[tuple[Element, str]]:
    """Each joint of the finished model, with its type in MJCF's words.

    MuJoCo numbers bodies depth first, in the order of the file, and of each body the joints in theirs (its
    documentation, "Computation", on the kinematic tree).
    """
    types = _class_types(root)
    for world in root.iterchildren("worldbody"):
        # Not recursive: a tree may be deeper than Python's stack.
        waiting: list[tuple[Element, str]] = [(world, "main")]
        while waiting:
            body, inherited = waiting.pop()
            inherited = body.get("childclass", inherited)
            below: list[tuple[Element, str]] = []
            for node, own in _inside(body, inherited):
                if node.tag == "freejoint":
                    yield node, "free"
                elif node.tag == "joint":
                    kind = node.get("type") or types.get(node.get("class", own), HINGE)
                    # What MuJoCo has no word for does not compile, which the validate stage says.
                    yield node, kind if kind in TYPES else HINGE
                else:
                    below.append((node, own))
            waiting += reversed(below)


def _inside(body: Element, inherited: str) -> Iterator[tuple[Element, str]]:
    """The joints and bodies of a body with the class that they inherit; a <frame> is no body."""
    for node in body.iterchildren(*JOINTS, "body", "frame"):
        if node.tag == "frame":
            yield from _inside(node, node.get("childclass", inherited))
        else:
            yield node, inherited


def _class_types(root: Element) -> dict[str, str]:
    """By class that gives joints a type, or is inside one that does: that type."""
    found: dict[str, str] = {}
    for section in root.iterchildren("default"):
        waiting = [(section, HINGE)]
        while waiting:
            node, inherited = waiting.pop()
            own = node.find("joint")
            kind = inherited if own is None else own.get("type", inherited)
            found[node.get("class", "main")] = kind
            waiting += [(below, kind) for below in node.iterchildren("default")]
    return found
