"""Every link and joint is there by name, and no other degree of freedom."""

from collections.abc import Iterator

import mujoco

from linkwright.stages.formats.xml import parse
from linkwright.stages.mujoco.names import body_index, joint_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import SCENE, CompiledModel
from linkwright.stages.validate.findings import differs, few, link, named, named_joint
from linkwright.stages.validate.model.coordinates import WIDTH, joints_of, missing_names, of_the_scene


def check(compiled: CompiledModel) -> Iterator[Check]:
    robot, model = compiled.robot, compiled.model
    floating = 0 if robot.base.fixed or compiled.urdf else 6
    expected = sum(WIDTH[kind] for _, kind, _ in joints_of(robot, compiled.urdf)) + floating
    expected += compiled.surplus.dofs
    surplus = model.nv - expected - _beside(compiled)
    missing = missing_names(compiled)
    detail = f"{count(len(robot.links), 'link')}, {_dofs(model.nv)}"
    if missing:
        detail = f"missing: {', '.join(missing)}"
    elif surplus:
        detail = f"expected {_dofs(expected)}, found {model.nv}"
    passed = not missing and surplus == 0
    found = [_missing(compiled, name) for name in missing] or list(_others(compiled))
    yield compiled.result("links and joints", passed, detail, float(abs(surplus)), 0.0, few(found))
    if passed and compiled.path.name != SCENE:
        yield _names(compiled)


def _names(compiled: CompiledModel) -> Check:
    """What a URDF calls its robot, by which others find its package and its groups; what an MJCF calls it,
    and the joint by which it floats."""
    robot, found = compiled.robot, list[Finding]()
    tag, attribute = ("robot", "name") if compiled.urdf else ("mujoco", "model")
    own = parse(compiled.path.read_bytes()).get(attribute, "")
    if own != robot.name and not any(attribute in one.sets for one in compiled.written.amendments.changes):
        found.append(differs(tag, attribute, f'"{own}"', f'"{robot.name}"'))
    if robot.base.joint and not compiled.urdf:
        joint = joint_index(compiled.model, robot.base.joint)
        if joint < 0:
            message = f'there is none, expected "{robot.base.joint}"'
            found.append(Finding(link(robot.root.name, False), "freejoint name", message))
    detail = found[0].message if found else f"the robot is called {robot.name}"
    return compiled.within("name", float(len(found)), 0.0, detail, found)


def _beside(compiled: CompiledModel) -> int:
    """The degrees of freedom of what lies beside the robot in a scene, without those that the user's own XML
    gave it, which are counted."""
    if compiled.path.name != SCENE:
        return 0
    strange = of_the_scene(compiled.model, compiled.robot)
    number = sum(int(body) in strange for body in compiled.model.dof_bodyid)
    return max(0, number - compiled.surplus.dofs)


def _missing(compiled: CompiledModel, name: str) -> Finding:
    is_link = any(link.name == name for link in compiled.robot.links)
    element = link(name, compiled.urdf) if is_link else named("joint", name)
    return Finding(element, "name", f"there is none of this name in {compiled.path.name}")


def _others(compiled: CompiledModel) -> Iterator[Finding]:
    """The joints that are not the robot's, and the joint by which it floats or does not."""
    model, robot = compiled.model, compiled.robot
    own = {name for name, *_ in joints_of(robot, compiled.urdf)}
    if not compiled.urdf:
        free = [index for index in range(model.njnt) if model.jnt_type[index] == mujoco.mjtJoint.mjJNT_FREE]
        root = body_index(model, robot.root.name)
        floats = [index for index in free if int(model.jnt_bodyid[index]) == root]
        own |= {model.joint(index).name for index in floats} if not robot.base.fixed else set()
        if not floats and not robot.base.fixed:
            yield Finding(
                link(robot.root.name, False), "freejoint", "has none, so the robot hangs in the air"
            )
    beside = of_the_scene(model, robot) if compiled.path.name == SCENE else ()
    for index in range(model.njnt):
        name = model.joint(index).name
        body = int(model.jnt_bodyid[index])
        if name not in own and body not in beside:
            message = f"is not one of the robot's; it moves {link(model.body(body).name, compiled.urdf)}"
            yield Finding(named_joint(model, index), "type", message)


def _dofs(number: int) -> str:
    return count(number, "degree of freedom", "degrees of freedom")
