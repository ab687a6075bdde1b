"""The table of a URDF: its joints that move, in the order of the file and in that of its tree."""

from collections.abc import Iterator, Mapping

from linkwright.stages.formats.robot_json.files import UrdfJointRow
from linkwright.stages.formats.xml import Element

UNITS = {"revolute": "rad", "continuous": "rad", "prismatic": "m", "floating": "m, rad", "planar": "m, rad"}
"""Type of joint → its unit; others do not move."""


def urdf_rows(root: Element, dofs: Mapping[str, str], mates: Mapping[str, str]) -> Iterator[UrdfJointRow]:
    """A row for each joint that moves, in the order of the file. `dofs`: joint → the robot's dof; `mates`:
    dof → what CAD calls its mate.

    `tree`: its place in a walk down the tree, depth first and siblings by name: so urdfdom's readers find
    them, such as Pinocchio, whose q and v are in this order.
    """
    joints = [node for node in root.iterchildren("joint") if node.get("type") in UNITS]
    places = {name: place for place, name in enumerate(_walked(root))}
    for index, node in enumerate(joints):
        name, mimic = node.get("name"), node.find("mimic")
        dof = dofs.get(name)
        yield UrdfJointRow(
            name=name,
            index=index,
            tree=places.get(name),
            type=node.get("type"),
            unit=UNITS[node.get("type")],
            follows=None if mimic is None else mimic.get("joint"),
            dof=dof,
            cad=mates.get(dof or ""),
        )


def _walked(root: Element) -> Iterator[str]:
    """The names of the joints that move, depth first, siblings by name."""
    below: dict[str, list[tuple[str, str, bool]]] = {}
    children = set()
    for node in root.iterchildren("joint"):
        ends = node.find("parent"), node.find("child")
        if None in ends:
            continue
        parent, child = (end.get("link") for end in ends)
        below.setdefault(parent, []).append((node.get("name"), child, node.get("type") in UNITS))
        children.add(child)
    roots = [node.get("name") for node in root.iterchildren("link") if node.get("name") not in children]
    waiting = [("", link, False) for link in reversed(roots)]
    while waiting:
        name, link, moves = waiting.pop()
        if moves:
            yield name
        waiting += sorted(below.get(link, ()), reverse=True)
