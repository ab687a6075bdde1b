"""Lists the joints of an MJCF in the order in which MuJoCo numbers them."""

from collections.abc import Iterator

from linkwright.stages.formats.xml import Element

JOINTS = ("joint", "freejoint")
"""The tags of joints."""

TYPES = ("hinge", "slide", "ball", "free")
"""The types of joints."""

HINGE = "hinge"
"""The type of a joint without a `type`."""


def joints_in_order(root: Element) -> Iterator[tuple[Element, str]]:
    """Yields each joint of the finished model, with its type in MJCF's words.

    MuJoCo numbers bodies depth first, in the order of the file, and the joints of each body in file order
    (its documentation, "Computation", on the kinematic tree).
    """
    types = _class_types(root)
    for world in root.iterchildren("worldbody"):
        # Not recursive: a tree may be deeper than Python's stack.
        waiting: list[tuple[Element, str]] = [(world, "main")]
        while waiting:
            body, inherited = waiting.pop()
            inherited = body.get("childclass", inherited)
            below: list[tuple[Element, str]] = []
            for node, node_class in _inside(body, inherited):
                if node.tag == "freejoint":
                    yield node, "free"
                elif node.tag == "joint":
                    kind = node.get("type") or types.get(node.get("class", node_class), HINGE)
                    # Types unknown to MuJoCo do not compile, which the validate stage reports.
                    yield node, kind if kind in TYPES else HINGE
                else:
                    below.append((node, node_class))
            waiting += reversed(below)


def _inside(body: Element, inherited: str) -> Iterator[tuple[Element, str]]:
    """Yields the joints and bodies of a body with the class that they inherit; a <frame> is not a body."""
    waiting = [(body, inherited)]
    while waiting:
        node, node_class = waiting.pop()
        if node is not body and node.tag != "frame":
            yield node, node_class
            continue
        class_inside = node_class if node is body else node.get("childclass", node_class)
        inner_nodes = list(node.iterchildren(*JOINTS, "body", "frame"))
        waiting += [(inner, class_inside) for inner in reversed(inner_nodes)]


def _class_types(root: Element) -> dict[str, str]:
    """Returns the type of joints by class, for classes that set a type or inherit it."""
    type_by_class: dict[str, str] = {}
    for section in root.iterchildren("default"):
        waiting = [(section, HINGE)]
        while waiting:
            node, inherited = waiting.pop()
            joint = node.find("joint")
            kind = inherited if joint is None else joint.get("type", inherited)
            type_by_class[node.get("class", "main")] = kind
            waiting += [(below, kind) for below in node.iterchildren("default")]
    return type_by_class
