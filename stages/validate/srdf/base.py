"""What an SRDF says of the robot's base, and of joints that nothing drives."""

from collections.abc import Iterator

from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.dynamics.passive import passive_dofs
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.srdf.known import ReadSrdf

WORLD = "world"
"""What the base is fixed to, or flies in."""


def base(read: ReadSrdf) -> Iterator[Finding]:
    """The robot's name, and the joint by which its root is in the world; none where the root is the world.
    What the source's SRDF calls the world is the world."""
    if read.root.get("name") != read.robot.name:
        yield differs(
            named("robot", read.root.get("name", "")), "name", read.root.get("name"), read.robot.name
        )
    found, root = read.root.findall("virtual_joint"), read.robot.root.name
    own = read.robot.semantics.virtual_joint
    if root == WORLD:
        for node in found:
            element = named("virtual_joint", node.get("name", ""))
            yield Finding(element, "", f"the root is {WORLD} itself, expected no such joint")
        return
    if not found:
        yield Finding("virtual_joint", "", f"there is none, expected one from {WORLD} to {root}")
    expected = {
        "type": "fixed" if read.robot.base.fixed else "floating",
        "child_link": root,
        "parent_frame": own.parent_frame if own else WORLD,
    }
    for node in found:
        element = named("virtual_joint", node.get("name", ""))
        if node.get("name") in read.joints:
            yield Finding(element, "name", "a joint of the URDF has this name")
        for key, value in expected.items():
            if node.get(key) != value and not (key == "child_link" and node.get(key) not in read.links):
                yield differs(element, key, node.get(key), value)


def passive(read: ReadSrdf) -> Iterator[Finding]:
    """Passive are the joints that nothing drives and that follow no other, and no others are."""
    turns = read.written.urdf_names.turns
    dofs = passive_dofs(read.robot, read.written.as_urdf.robot, read.written.actuation)
    expected = [name for dof in dofs for name in turns.get(dof, (dof,))]
    found = [node.get("name", "") for node in read.root.findall("passive_joint")]
    followers = {one.follower for one in read.written.as_urdf.robot.relations}
    for name in found:
        if name in read.chains.joints and name not in expected:
            dof = read.chains.joints[name].dof
            why = "is fixed" if dof is None else "follows another" if dof.name in followers else "is driven"
            yield Finding(named("passive_joint", name), "name", f"{why}, and is not passive")
    for name in expected:
        if name not in found:
            yield Finding(named("passive_joint", name), "name", "there is none, and nothing drives the joint")
