"""Checks that the links and joints of a file are a tree, and reports all problems at once."""

from collections import Counter
from collections.abc import Iterable, Mapping

import networkx as nx

from linkwright.stages.formats.urdf.model import Urdf, UrdfJoint, UrdfMimic
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.text.globs import name_list

SCALAR_TYPES = ("revolute", "continuous", "prismatic")
"""Types of joints whose value is a number."""


def check_structure(urdf: Urdf, disconnected: bool, log: Diagnostics) -> None:
    """Reports E-URDF-* for each fault by which links and joints are not a tree, at its joint or link.

    `disconnected`: whether several roots are allowed, since the user has chosen what becomes of them.
    """
    links = {link.name for link in urdf.links}
    link_list = f"links are: {name_list(links)}"
    valid_joints = [joint for joint in urdf.joints if _has_both_ends(joint, links, link_list, log)]
    _check_parents(valid_joints, log)
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(links)
    graph.add_edges_from((joint.parent, joint.child) for joint in valid_joints)
    groups = sorted(sorted(group) for group in nx.strongly_connected_components(graph) if len(group) > 1)
    group_of = {name: number for number, group in enumerate(groups) for name in group}
    joints_by_group: list[list[str]] = [[] for _ in groups]
    for joint in valid_joints:
        if joint.parent in group_of and group_of[joint.parent] == group_of.get(joint.child):
            joints_by_group[group_of[joint.parent]].append(joint.name)
    for group, names in zip(groups, joints_by_group, strict=True):
        text = f"the links {name_list(group)} form a cycle"
        log.report("E-URDF-CYCLE", text, name_list(names), "a URDF must be a tree: remove one of the joints")
    roots = sorted(name for name in links if graph.in_degree(name) == 0)
    if len(roots) > 1 and not disconnected:
        text = f"{len(roots)} links have no parent: {name_list(roots)}"
        hint = "connect them by joints, or choose root.disconnected=weld, drop or separate"
        log.report("E-URDF-ROOTS", text, urdf.name, hint)
    _check_mimics(urdf, log)


def _has_both_ends(joint: UrdfJoint, links: set[str], link_list: str, log: Diagnostics) -> bool:
    missing_ends = [f"{side} {name!r}" for side, name in _ends(joint) if name not in links]
    if missing_ends:
        text = f"these do not exist: its {' and '.join(missing_ends)}"
        log.report("E-URDF-LINK", text, joint.name, link_list)
    elif joint.parent == joint.child:
        text = f"it joins the link {joint.parent!r} to itself"
        log.report("E-URDF-SELF", text, joint.name, "name two different links")
        return False
    return not missing_ends


def _ends(joint: UrdfJoint) -> Iterable[tuple[str, str]]:
    return ("parent", joint.parent), ("child", joint.child)


def _check_parents(joints: Iterable[UrdfJoint], log: Diagnostics) -> None:
    joints_above: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        joints_above.setdefault(joint.child, []).append(joint)
    for child, parents in sorted(joints_above.items()):
        if len(parents) > 1:
            text = f"the link has {len(parents)} parent joints: {', '.join(sorted(j.name for j in parents))}"
            hint = "a link of a URDF has one parent: a loop must be closed in the MJCF, by an equality"
            log.report("E-URDF-PARENTS", text, child, hint)


def _check_mimics(urdf: Urdf, log: Diagnostics) -> None:
    """Reports E-URDF-MIMIC for a joint that cannot follow the joint that its <mimic> names."""
    counts = Counter(joint.name for joint in urdf.joints)
    joints = {joint.name: joint for joint in urdf.joints if counts[joint.name] == 1}
    circles = _circles({name: joint.mimic.joint for name, joint in joints.items() if joint.mimic})
    hint = "correct the <mimic>, or remove it"
    for joint in sorted(joints.values(), key=lambda joint: joint.name):
        if joint.mimic is not None and joint.type in SCALAR_TYPES:
            fault = _mimic_fault(joint, joint.mimic, joints, circles)
            if fault:
                log.report("E-URDF-MIMIC", fault, joint.name, hint)


def _mimic_fault(
    joint: UrdfJoint, mimic: UrdfMimic, joints: Mapping[str, UrdfJoint], circles: Mapping[str, str]
) -> str:
    """Returns the reason why the joint cannot follow; "" if it can."""
    if mimic.joint == joint.name:
        return "it mimics itself"
    driver = joints.get(mimic.joint)
    if driver is None:
        return f"it mimics {mimic.joint!r}, which is not a joint"
    if driver.type not in SCALAR_TYPES:
        return f"it mimics {mimic.joint!r}, which is {driver.type} and so has no single value"
    return f"it mimics in a cycle: {circles[joint.name]}" if joint.name in circles else ""


def _circles(parents: Mapping[str, str]) -> dict[str, str]:
    """Returns for each name in a circle of parents the list of the circle's names, as a text."""
    circles: dict[str, str] = {}
    visited: set[str] = set()
    for name in parents:
        path: dict[str, None] = {}
        while name in parents and name not in visited:
            visited.add(name)
            path[name] = None
            name = parents[name]
        if name in path:
            circle = list(path)[list(path).index(name) :]
            circles |= dict.fromkeys(circle, name_list(circle))
    return circles


def top_ancestors(parents: Mapping[str, str]) -> dict[str, str]:
    """Returns the topmost ancestor of each name that has a parent."""
    ancestors_by_name: dict[str, str] = {}
    for name in parents:
        path = []
        while name in parents and name not in ancestors_by_name:
            path.append(name)
            name = parents[name]
        ancestors_by_name |= dict.fromkeys(path, ancestors_by_name.get(name, name))
    return ancestors_by_name
