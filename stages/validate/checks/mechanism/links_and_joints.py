"""Checks that every link and joint exists by name, and that there are no further degrees of freedom."""

from collections.abc import Iterator

from linkwright.stages.formats.xml import parse
from linkwright.stages.mujoco.names import body_index, joint_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import SCENE, CompiledModel
from linkwright.stages.validate.findings import differs, few, link, named, named_joint
from linkwright.stages.validate.model.coordinates import (
    DOFS_OF_TYPE,
    FREE,
    bodies_of_scene,
    find_missing_names,
    joints_of,
)


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks that the model has all links and joints of the robot, and no further dofs. If this passes, also
    checks the robot's name in the file, except in a scene, whose name is free."""
    robot, model = compiled.robot, compiled.model
    # A URDF cannot say that its root floats.
    base_dofs = 0 if robot.base.fixed or compiled.urdf else 6
    expected_dofs = sum(DOFS_OF_TYPE[kind] for _, kind, _ in joints_of(robot, compiled.urdf)) + base_dofs
    expected_dofs += compiled.surplus.dofs
    dof_difference = model.nv - expected_dofs - _object_dofs(compiled)
    missing_names = find_missing_names(compiled)
    detail = f"{count(len(robot.links), 'link')}, {_dofs_text(model.nv)}"
    if missing_names:
        detail = f"missing: {', '.join(missing_names)}"
    elif dof_difference:
        detail = f"expected {_dofs_text(expected_dofs)}, found {model.nv}"
    passed = not missing_names and dof_difference == 0
    findings = [_missing_element(compiled, name) for name in missing_names] or list(_joint_findings(compiled))
    yield compiled.result("links and joints", passed, detail, float(abs(dof_difference)), 0.0, few(findings))
    if passed and compiled.path.name != SCENE:
        yield _check_names(compiled)


def _check_names(compiled: CompiledModel) -> Check:
    """Compares the robot's name, by which other tools find its package and its groups; in an MJCF also the
    name of the joint by which the robot floats. A name that the user's own XML sets is not compared."""
    robot, findings = compiled.robot, list[Finding]()
    tag, attribute = ("robot", "name") if compiled.urdf else ("mujoco", "model")
    name = parse(compiled.path.read_bytes()).get(attribute, "")
    if name != robot.name and not compiled.sets(attribute):
        findings.append(differs(tag, attribute, f'"{name}"', f'"{robot.name}"'))
    if robot.base.joint and not compiled.urdf and joint_index(compiled.model, robot.base.joint) < 0:
        message = f'is missing, expected "{robot.base.joint}"'
        findings.append(Finding(link(robot.root.name, urdf=False), "freejoint name", message))
    detail = f"the robot's name is {robot.name}"
    if findings:
        detail = f"{findings[0].element} {findings[0].attribute} {findings[0].message}"
    return compiled.within("name", float(len(findings)), 0.0, detail, findings)


def _object_dofs(compiled: CompiledModel) -> int:
    """Returns the number of dofs of a scene's other objects, without those from the user's own XML, which
    `check` expects anyway."""
    if compiled.path.name != SCENE:
        return 0
    scene_bodies = bodies_of_scene(compiled.model, compiled.robot)
    dof_count = sum(int(body) in scene_bodies for body in compiled.model.dof_bodyid)
    # Not below 0: the surplus also counts dofs that the user's own XML gives to the robot itself.
    return max(0, dof_count - compiled.surplus.dofs)


def _missing_element(compiled: CompiledModel, name: str) -> Finding:
    """Returns the finding on a missing link or joint."""
    is_link = name in {robot_link.name for robot_link in compiled.robot.links}
    element = link(name, compiled.urdf) if is_link else named("joint", name)
    return Finding(element, "name", f"is missing in {compiled.path.name}")


def _joint_findings(compiled: CompiledModel) -> Iterator[Finding]:
    """Yields a finding if the robot should float and the model has no joint for that; then a finding on each
    joint that the robot does not have, such as a free joint of a fixed robot."""
    model, robot = compiled.model, compiled.robot
    names = {name for name, *_ in joints_of(robot, compiled.urdf)}
    if not compiled.urdf and not robot.base.fixed:
        root = body_index(model, robot.root.name)
        base_joints = {
            model.joint(index).name
            for index in range(model.njnt)
            if model.jnt_type[index] == FREE and int(model.jnt_bodyid[index]) == root
        }
        names |= base_joints
        if not base_joints:
            message = "is missing, so the root link cannot move"
            yield Finding(link(robot.root.name, urdf=False), "freejoint", message)
    scene_bodies = bodies_of_scene(model, robot) if compiled.path.name == SCENE else ()
    for index in range(model.njnt):
        name = model.joint(index).name
        body = int(model.jnt_bodyid[index])
        if name not in names and body not in scene_bodies:
            message = f"is not part of the robot; it moves {link(model.body(body).name, compiled.urdf)}"
            yield Finding(named_joint(model, index), "type", message)


def _dofs_text(dof_count: int) -> str:
    """Returns a number of dofs for a message, such as "6 degrees of freedom"."""
    return count(dof_count, "degree of freedom", "degrees of freedom")
