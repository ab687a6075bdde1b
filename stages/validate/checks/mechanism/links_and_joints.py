"""Checks that every link and joint exists by name, and that there are no further degrees of freedom."""

from collections.abc import Iterator

import mujoco

from linkwright.stages.formats.xml import parse
from linkwright.stages.mujoco.names import body_index, joint_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import SCENE, CompiledModel
from linkwright.stages.validate.findings import differs, few, link, named, named_joint
from linkwright.stages.validate.model.coordinates import (
    DOFS_OF_TYPE,
    bodies_of_scene,
    joints_of,
    missing_names,
)


def check(compiled: CompiledModel) -> Iterator[Check]:
    robot, model = compiled.robot, compiled.model
    floating = 0 if robot.base.fixed or compiled.urdf else 6
    expected = sum(DOFS_OF_TYPE[kind] for _, kind, _ in joints_of(robot, compiled.urdf)) + floating
    expected += compiled.surplus.dofs
    surplus = model.nv - expected - _beside(compiled)
    missing = missing_names(compiled)
    detail = f"{count(len(robot.links), 'link')}, {_dofs(model.nv)}"
    if missing:
        detail = f"missing: {', '.join(missing)}"
    elif surplus:
        detail = f"expected {_dofs(expected)}, found {model.nv}"
    passed = not missing and surplus == 0
    findings = [_missing(compiled, name) for name in missing] or list(_others(compiled))
    yield compiled.result("links and joints", passed, detail, float(abs(surplus)), 0.0, few(findings))
    if passed and compiled.path.name != SCENE:
        yield _names(compiled)


def _names(compiled: CompiledModel) -> Check:
    """Compares the robot's name, by which other tools find its package and its groups; in an MJCF also the
    name of the joint by which it floats."""
    robot, findings = compiled.robot, list[Finding]()
    tag, attribute = ("robot", "name") if compiled.urdf else ("mujoco", "model")
    name = parse(compiled.path.read_bytes()).get(attribute, "")
    if name != robot.name and not any(
        attribute in change.sets for change in compiled.written.amendments.changes
    ):
        findings.append(differs(tag, attribute, f'"{name}"', f'"{robot.name}"'))
    if robot.base.joint and not compiled.urdf:
        joint = joint_index(compiled.model, robot.base.joint)
        if joint < 0:
            message = f'is missing, expected "{robot.base.joint}"'
            findings.append(Finding(link(robot.root.name, False), "freejoint name", message))
    detail = findings[0].message if findings else f"the robot is called {robot.name}"
    return compiled.within("name", float(len(findings)), 0.0, detail, findings)


def _beside(compiled: CompiledModel) -> int:
    """Returns the number of dofs of a scene's other objects, without those from the user's own XML, which are
    counted elsewhere."""
    if compiled.path.name != SCENE:
        return 0
    scene_bodies = bodies_of_scene(compiled.model, compiled.robot)
    number = sum(int(body) in scene_bodies for body in compiled.model.dof_bodyid)
    return max(0, number - compiled.surplus.dofs)


def _missing(compiled: CompiledModel, name: str) -> Finding:
    is_link = any(link.name == name for link in compiled.robot.links)
    element = link(name, compiled.urdf) if is_link else named("joint", name)
    return Finding(element, "name", f"is missing in {compiled.path.name}")


def _others(compiled: CompiledModel) -> Iterator[Finding]:
    """Yields the joints that are not the robot's, and a joint by which it floats although the configuration
    fixes it."""
    model, robot = compiled.model, compiled.robot
    names = {name for name, *_ in joints_of(robot, compiled.urdf)}
    if not compiled.urdf:
        free = [index for index in range(model.njnt) if model.jnt_type[index] == mujoco.mjtJoint.mjJNT_FREE]
        root = body_index(model, robot.root.name)
        floats = [index for index in free if int(model.jnt_bodyid[index]) == root]
        names |= {model.joint(index).name for index in floats} if not robot.base.fixed else set()
        if not floats and not robot.base.fixed:
            yield Finding(
                link(robot.root.name, False), "freejoint", "is missing, so the robot hangs in the air"
            )
    scene_bodies = bodies_of_scene(model, robot) if compiled.path.name == SCENE else ()
    for index in range(model.njnt):
        name = model.joint(index).name
        body = int(model.jnt_bodyid[index])
        if name not in names and body not in scene_bodies:
            message = f"is not part of the robot; it moves {link(model.body(body).name, compiled.urdf)}"
            yield Finding(named_joint(model, index), "type", message)


def _dofs(number: int) -> str:
    return count(number, "degree of freedom", "degrees of freedom")
