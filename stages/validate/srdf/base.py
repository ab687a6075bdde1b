"""Checks the robot's base in an SRDF, and its passive joints."""

from collections.abc import Iterator

from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.dynamics.passive import passive_dofs
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.srdf.read_srdf import ReadSrdf

WORLD = "world"
"""The frame to which the base is fixed, or in which it floats."""


def base_findings(read: ReadSrdf) -> Iterator[Finding]:
    """Compares the robot's name, and the virtual joint between its root and the world. A root that is the
    world has no such joint. The world has the name that the source's SRDF gives it."""
    if read.root.get("name") != read.robot.name:
        yield differs(
            named("robot", read.root.get("name", "")), "name", read.root.get("name"), read.robot.name
        )
    nodes, root = read.root.findall("virtual_joint"), read.robot.root.name
    source_joint = read.robot.semantics.virtual_joint
    if root == WORLD:
        for node in nodes:
            element = named("virtual_joint", node.get("name", ""))
            yield Finding(element, "", f"the root is {WORLD} itself, expected no such joint")
        return
    if not nodes:
        yield Finding("virtual_joint", "", f"is missing, expected a joint from {WORLD} to {root}")
    expected = {
        "type": "fixed" if read.robot.base.fixed else "floating",
        "child_link": root,
        "parent_frame": source_joint.parent_frame if source_joint else WORLD,
    }
    for node in nodes:
        element = named("virtual_joint", node.get("name", ""))
        if node.get("name") in read.joints:
            yield Finding(element, "name", "a joint of the URDF has this name")
        for key, value in expected.items():
            # The check of the names reports a link that does not exist.
            is_unknown_link = key == "child_link" and node.get(key) not in read.links
            if node.get(key) != value and not is_unknown_link:
                yield differs(element, key, node.get(key), value)


def passive_joint_findings(read: ReadSrdf) -> Iterator[Finding]:
    """Yields passive joints that are fixed, are driven or follow another joint, and undriven joints that are
    not passive."""
    turns = read.written.urdf_names.turns
    dofs = passive_dofs(read.robot, read.written.as_urdf.robot, read.written.actuation)
    expected = [name for dof in dofs for name in turns.get(dof, (dof,))]
    names = [node.get("name", "") for node in read.root.findall("passive_joint")]
    followers = {relation.follower for relation in read.written.as_urdf.robot.relations}
    for name in names:
        if name in read.chains.joints and name not in expected:
            dof = read.chains.joints[name].dof
            if dof is None:
                reason = "is fixed"
            else:
                reason = "follows another" if dof.name in followers else "is driven"
            yield Finding(named("passive_joint", name), "name", f"{reason}, and is not passive")
    for name in expected:
        if name not in names:
            yield Finding(named("passive_joint", name), "name", "is missing, and nothing drives the joint")
