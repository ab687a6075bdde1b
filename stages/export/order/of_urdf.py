"""Lists the moving joints of a URDF, in the order of the file and in the order of its tree."""

from collections.abc import Iterator, Mapping

from linkwright.stages.formats.robot_json.files import UrdfJointRow
from linkwright.stages.formats.xml import Element

UNITS = {"revolute": "rad", "continuous": "rad", "prismatic": "m", "floating": "m, rad", "planar": "m, rad"}
"""Type of joint → its unit; joints of other types do not move."""


def urdf_rows(root: Element, dofs: Mapping[str, str], mates: Mapping[str, str]) -> Iterator[UrdfJointRow]:
    """Yields a row for each moving joint, in the order of the file. `dofs`: joint → the robot's dof; `mates`:
    dof → the name of its mate in CAD.

    The `tree` of a row is the position of the joint in a walk down the tree, depth first and siblings by
    name. Readers that use urdfdom have this order, such as Pinocchio in q and v.
    """
    joints = [node for node in root.iterchildren("joint") if node.get("type") in UNITS]
    positions = {name: position for position, name in enumerate(_tree_order(root))}
    for index, node in enumerate(joints):
        name, mimic = node.get("name"), node.find("mimic")
        dof = dofs.get(name)
        yield UrdfJointRow(
            name=name,
            index=index,
            tree=positions.get(name),
            type=node.get("type"),
            unit=UNITS[node.get("type")],
            follows=None if mimic is None else mimic.get("joint"),
            dof=dof,
            cad=mates.get(dof or ""),
        )


def _tree_order(root: Element) -> Iterator[str]:
    """Yields the names of the moving joints, depth first, siblings by name."""
    children_of: dict[str, list[tuple[str, str, bool]]] = {}
    children = set()
    for node in root.iterchildren("joint"):
        ends = node.find("parent"), node.find("child")
        if None in ends:
            continue
        parent, child = (end.get("link") for end in ends)
        # A joint of the user's own XML may lack a name.
        name = node.get("name", "")
        children_of.setdefault(parent, []).append((name, child, node.get("type") in UNITS))
        children.add(child)
    roots = [node.get("name") for node in root.iterchildren("link") if node.get("name") not in children]
    stack = [("", link, False) for link in reversed(roots)]
    while stack:
        name, link, moves = stack.pop()
        if moves:
            yield name
        stack += sorted(children_of.get(link, ()), reverse=True)
