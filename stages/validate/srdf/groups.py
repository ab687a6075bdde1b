"""The groups of an SRDF and its end effectors, against the robot."""

from collections.abc import Collection, Iterator

from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.srdf.known import ALL, ReadSrdf


def groups(read: ReadSrdf) -> Iterator[Finding]:
    """Each chain is one of the robot; none is empty, or there twice. The groups of the source are there,
    with their joints. Without them chains end where their names say, each frame that moves has a group, and
    one group has all joints."""
    known = {*read.chains.joints, *read.chains.links, *read.groups}
    for node in read.root.findall("group"):
        name, element = node.get("name", ""), named("group", node.get("name", ""))
        if read.groups[name] is not node:
            yield Finding(element, "name", "another group has this name")
            continue
        wrong = list(_chains(read, node))
        yield from wrong
        keys = ("name", "base_link", "tip_link")
        held = {one.get(key) for one in node.iterchildren() for key in keys if one.get(key)}
        # Of what is unknown, or of the user's own XML, nothing can be said.
        foreign = held - known
        if not wrong and not foreign and not read.moved_by(name):
            yield Finding(element, "", "moves nothing")
    if read.source_groups:
        yield from _of_source(read)
        return
    for link in _framed(read):
        if link not in read.groups:
            yield Finding(named("group", link), "name", f"there is none, expected the chain to {link}")
    every = read.moving
    found = [name for name in read.groups if read.moved_by(name) == every]
    whole = read.groups.get(ALL)
    judged = whole is not None and whole.find("chain") is None and not read.chains.has(ALL)
    if every and (judged and ALL not in found):
        missing = sorted(every - read.moved_by(ALL))
        yield Finding(named("group", ALL), "joint", f"is without {', '.join(missing)}, expected every joint")
    elif every and not found:
        yield Finding(named("group", ALL), "name", "there is none, and no other group has every joint")


def _of_source(read: ReadSrdf) -> Iterator[Finding]:
    """What is different of the groups of the robot's source."""
    for name, joints in read.source_groups.items():
        if name not in read.groups:
            yield Finding(named("group", name), "name", "there is none, and the robot's source has it")
        elif read.moved_by(name) != joints:
            words = f"moves {_listed(read.moved_by(name))}, expected {_listed(joints)}"
            yield Finding(named("group", name), "joint", words)


def _chains(read: ReadSrdf, node: Element) -> Iterator[Finding]:
    name = node.get("name", "")
    element = named("group", name)
    chains = node.findall("chain")
    for one in chains:
        base, tip = one.get("base_link", ""), one.get("tip_link", "")
        if not (read.chains.has(base) and read.chains.has(tip)):
            continue  # unknown, or of the user's own XML
        if read.chains.has(name) and len(chains) == 1 and not read.source_groups:
            if tip != name:
                yield differs(element, "chain tip_link", tip, name)
            if base != read.chains.base_of(name):
                yield differs(element, "chain base_link", base, read.chains.base_of(name))
        elif read.chains.between(base, tip) is None:
            yield Finding(element, "chain base_link", f'is "{base}", which "{tip}" does not hang on')


def _framed(read: ReadSrdf) -> Iterator[str]:
    """The links of the URDF that are frames of the robot, and that joints of groups move."""
    for link in read.written.urdf_names.frames.values():
        if read.joints_to(link):
            yield link


def end_effectors(read: ReadSrdf) -> Iterator[Finding]:
    """None is missing. Each that the robot's source has is as that has it; any other is all that its parent
    link carries, at the end of the group that moves that link."""
    source = {effector.name: effector for effector in read.robot.semantics.end_effectors}
    nodes = {node.get("name", ""): node for node in read.root.findall("end_effector")}
    srdf = read.written.srdf_form
    for name in dict.fromkeys((*source, *(srdf.end_effectors if srdf is not None else ()))):
        if name not in nodes:
            yield Finding(named("end_effector", name), "name", "there is none")
    for name, effector in source.items():
        node = nodes.get(name)
        if node is None:
            continue
        for key in ("group", "parent_group"):
            if node.get(key, "") != getattr(effector, key):
                yield differs(named("end_effector", name), key, node.get(key), getattr(effector, key))
    for node in read.root.findall("end_effector"):
        if node.get("name", "") not in source:
            yield from _end_of_arm(read, node)


def _end_of_arm(read: ReadSrdf, node: Element) -> Iterator[Finding]:
    element, parent = named("end_effector", node.get("name", "")), node.get("parent_link", "")
    group, arm = node.get("group", ""), node.get("parent_group", "")
    if not read.chains.has(parent) or not {group, arm} <= read.groups.keys():
        return
    own, beyond = read.moved_by(group), read.joints_beyond(parent)
    if own != beyond:
        carriers = sorted({read.chains.joints[name].parent for name in own})
        fits = [link for link in carriers if read.joints_beyond(link) == own]
        if fits:
            yield differs(element, "parent_link", parent, " or ".join(fits))
            return
        words = f"moves {_listed(own)}, expected all that {parent} carries: {_listed(beyond)}"
        yield Finding(element, "group", words)
    if read.moved_by(arm) != read.joints_to(parent):
        words = f"moves {_listed(read.moved_by(arm))}, expected what moves {parent}: "
        yield Finding(element, "parent_group", words + _listed(read.joints_to(parent)))


def _listed(names: Collection[str]) -> str:
    return ", ".join(sorted(names)) or "nothing"
