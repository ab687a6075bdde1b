"""Compares the groups and end effectors of an SRDF with the robot."""

from collections.abc import Collection, Iterator

from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.srdf.read_srdf import ALL, ReadSrdf


def groups(read: ReadSrdf) -> Iterator[Finding]:
    """Checks that each chain is a chain of the robot, and that no group is empty or exists twice.

    Groups of the source must exist with their joints. If the source has no groups, chains must end where
    their names say, each moving frame must have a group, and a group must have all joints.
    """
    names = {*read.chains.joints, *read.chains.links, *read.groups}
    for node in read.root.findall("group"):
        name, element = node.get("name", ""), named("group", node.get("name", ""))
        if read.groups[name] is not node:
            yield Finding(element, "name", "another group has this name")
            continue
        wrong = list(_chains(read, node))
        yield from wrong
        keys = ("name", "base_link", "tip_link")
        names_used = {child.get(key) for child in node.iterchildren() for key in keys if child.get(key)}
        # Nothing is known about links and joints that do not exist, or that the user's own XML adds.
        foreign = names_used - names
        if not wrong and not foreign and not read.moved_by(name):
            yield Finding(element, "", "moves nothing")
    if read.source_groups:
        yield from _of_source(read)
        return
    for link in _moving_frames(read):
        if link not in read.groups:
            yield Finding(named("group", link), "name", f"is missing, expected the chain to {link}")
    joints = read.moving
    complete = [name for name in read.groups if read.moved_by(name) == joints]
    group_of_all = read.groups.get(ALL)
    is_judged = group_of_all is not None and group_of_all.find("chain") is None and not read.chains.has(ALL)
    if joints and (is_judged and ALL not in complete):
        missing = sorted(joints - read.moved_by(ALL))
        yield Finding(named("group", ALL), "joint", f"is without {', '.join(missing)}, expected every joint")
    elif joints and not complete:
        yield Finding(named("group", ALL), "name", "is missing, and no other group has every joint")


def _of_source(read: ReadSrdf) -> Iterator[Finding]:
    """Yields the differences from the groups of the robot's source."""
    for name, joints in read.source_groups.items():
        if name not in read.groups:
            yield Finding(named("group", name), "name", "is missing, and the robot's source has it")
        elif read.moved_by(name) != joints:
            message = f"moves {_listed(read.moved_by(name))}, expected {_listed(joints)}"
            yield Finding(named("group", name), "joint", message)


def _chains(read: ReadSrdf, node: Element) -> Iterator[Finding]:
    name = node.get("name", "")
    element = named("group", name)
    chains = node.findall("chain")
    for chain in chains:
        base, tip = chain.get("base_link", ""), chain.get("tip_link", "")
        if not (read.chains.has(base) and read.chains.has(tip)):
            continue  # unknown, or of the user's own XML
        if read.chains.has(name) and len(chains) == 1 and not read.source_groups:
            if tip != name:
                yield differs(element, "chain tip_link", tip, name)
            if base != read.chains.base_of(name):
                yield differs(element, "chain base_link", base, read.chains.base_of(name))
        elif read.chains.between(base, tip) is None:
            yield Finding(element, "chain base_link", f'is "{base}", which "{tip}" does not hang on')


def _moving_frames(read: ReadSrdf) -> Iterator[str]:
    """Yields the links of the URDF that are frames of the robot and are moved by joints of groups."""
    for link in read.written.urdf_names.frames.values():
        if read.joints_to(link):
            yield link


def end_effectors(read: ReadSrdf) -> Iterator[Finding]:
    """Checks that every end effector exists. End effectors of the source must be as in the source; all others
    must have everything that their parent link carries, at the end of the group that moves that link."""
    source = {effector.name: effector for effector in read.robot.semantics.end_effectors}
    nodes = {node.get("name", ""): node for node in read.root.findall("end_effector")}
    srdf = read.written.srdf_form
    for name in dict.fromkeys((*source, *(srdf.end_effectors if srdf is not None else ()))):
        if name not in nodes:
            yield Finding(named("end_effector", name), "name", "is missing")
    for name, effector in source.items():
        node = nodes.get(name)
        if node is None:
            continue
        expected = {
            "group": effector.group,
            "parent_link": read.link_of(effector.parent_link),
            "parent_group": effector.parent_group,
        }
        for key, value in expected.items():
            if node.get(key, "") != value:
                yield differs(named("end_effector", name), key, node.get(key), value)
    for node in read.root.findall("end_effector"):
        if node.get("name", "") not in source:
            yield from _end_of_arm(read, node)


def _end_of_arm(read: ReadSrdf, node: Element) -> Iterator[Finding]:
    element, parent = named("end_effector", node.get("name", "")), node.get("parent_link", "")
    group, arm = node.get("group", ""), node.get("parent_group", "")
    if not read.chains.has(parent) or not {group, arm} <= read.groups.keys():
        return
    moved_joints, beyond = read.moved_by(group), read.joints_beyond(parent)
    if moved_joints != beyond:
        carriers = sorted({read.chains.joints[name].parent for name in moved_joints})
        fits = [link for link in carriers if read.joints_beyond(link) == moved_joints]
        if fits:
            yield differs(element, "parent_link", parent, " or ".join(fits))
            return
        message = f"moves {_listed(moved_joints)}, expected all that {parent} carries: {_listed(beyond)}"
        yield Finding(element, "group", message)
    if read.moved_by(arm) != read.joints_to(parent):
        message = f"moves {_listed(read.moved_by(arm))}, expected what moves {parent}: "
        yield Finding(element, "parent_group", message + _listed(read.joints_to(parent)))


def _listed(names: Collection[str]) -> str:
    return ", ".join(sorted(names)) or "nothing"
