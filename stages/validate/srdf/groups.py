"""Compares the groups and end effectors of an SRDF with the robot."""

from collections.abc import Collection, Iterator

from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.srdf.read_srdf import GROUP_OF_ALL, ReadSrdf


def group_findings(read: ReadSrdf) -> Iterator[Finding]:
    """Checks that each chain is a chain of the robot, and that no group is empty or exists twice.

    Groups of the source must exist with their joints. If the source has no groups, a chain must end at the
    link whose name it has, each moving frame must have a group, and a group must have all joints.
    """
    names = {*read.chains.joints, *read.chains.links, *read.groups}
    for node in read.root.findall("group"):
        name, element = node.get("name", ""), named("group", node.get("name", ""))
        if read.groups[name] is not node:
            yield Finding(element, "name", "another group has this name")
            continue
        chain_findings = list(_chain_findings(read, node))
        yield from chain_findings
        keys = ("name", "base_link", "tip_link")
        names_used = {child.get(key) for child in node.iterchildren() for key in keys if child.get(key)}
        # Nothing is known about links and joints that do not exist, or that the user's own XML adds.
        foreign = names_used - names
        if not chain_findings and not foreign and not read.moved_by(name):
            yield Finding(element, "", "moves nothing")
    if read.source_groups:
        yield from _source_differences(read)
        return
    for link in _moving_frames(read):
        if link not in read.groups:
            yield Finding(named("group", link), "name", f"is missing, expected the chain to {link}")
    yield from _findings_on_all_joints(read)


def _findings_on_all_joints(read: ReadSrdf) -> Iterator[Finding]:
    """Checks that a group has all joints: the group of this name, unless it is a chain or is named after a
    link, else any group."""
    element, joints = named("group", GROUP_OF_ALL), read.moving_joints
    if not joints:
        return
    complete_groups = [name for name in read.groups if read.moved_by(name) == joints]
    group = read.groups.get(GROUP_OF_ALL)
    is_judged = group is not None and group.find("chain") is None and not read.chains.has(GROUP_OF_ALL)
    if is_judged and GROUP_OF_ALL not in complete_groups:
        missing = sorted(joints - read.moved_by(GROUP_OF_ALL))
        yield Finding(element, "joint", f"is without {', '.join(missing)}, expected every joint")
    elif not complete_groups:
        yield Finding(element, "name", "is missing, and no other group has every joint")


def _source_differences(read: ReadSrdf) -> Iterator[Finding]:
    """Yields the differences from the groups of the robot's source."""
    for name, joints in read.source_groups.items():
        if name not in read.groups:
            yield Finding(named("group", name), "name", "is missing, and the robot's source has it")
        elif read.moved_by(name) != joints:
            message = f"moves {_listed(read.moved_by(name))}, expected {_listed(joints)}"
            yield Finding(named("group", name), "joint", message)


def _chain_findings(read: ReadSrdf, node: Element) -> Iterator[Finding]:
    """Yields the chains of a group that are not chains of the robot, or that end elsewhere than the group's
    name says."""
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


def end_effector_findings(read: ReadSrdf) -> Iterator[Finding]:
    """Checks that every end effector exists. End effectors of the source must be as in the source. The group
    of any other must have all joints that its parent link carries, and its parent group those that move this
    link."""
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
            yield from _end_of_arm_findings(read, node)


def _end_of_arm_findings(read: ReadSrdf, node: Element) -> Iterator[Finding]:
    """Checks an end effector that is not the source's; nothing is known about other links and groups."""
    element, parent = named("end_effector", node.get("name", "")), node.get("parent_link", "")
    group, arm = node.get("group", ""), node.get("parent_group", "")
    if not read.chains.has(parent) or not {group, arm} <= read.groups.keys():
        return
    moved_joints, beyond = read.moved_by(group), read.joints_beyond(parent)
    if moved_joints != beyond:
        carriers = sorted({read.chains.joints[name].parent for name in moved_joints})
        fitting_links = [link for link in carriers if read.joints_beyond(link) == moved_joints]
        if fitting_links:
            yield differs(element, "parent_link", parent, " or ".join(fitting_links))
            return
        message = f"moves {_listed(moved_joints)}, expected all that {parent} carries: {_listed(beyond)}"
        yield Finding(element, "group", message)
    if read.moved_by(arm) != read.joints_to(parent):
        message = f"moves {_listed(read.moved_by(arm))}, expected what moves {parent}: "
        yield Finding(element, "parent_group", message + _listed(read.joints_to(parent)))


def _listed(names: Collection[str]) -> str:
    """Returns the names in their order, or "nothing"."""
    return ", ".join(sorted(names)) or "nothing"
