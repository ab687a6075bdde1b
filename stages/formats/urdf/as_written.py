"""Converts a robot to the robot that its URDF describes: links merged, loops replaced by mimics."""

from collections.abc import Sequence
from dataclasses import replace

from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.urdf.transmissions import with_joints
from linkwright.stages.robot.dynamics.fusing import Holders, fused
from linkwright.stages.robot.model.robot import Relation, Robot
from linkwright.stages.robot.motion.loop_lines import closed_loops, linear_couplings
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.text.names import free


def urdf_form(robot: Robot, merged: bool = False, preferred_drivers: Sequence[str] = ()) -> UrdfForm:
    """Returns the form of a robot's URDF. `preferred_drivers`: names of dofs to prefer as drivers of closed
    loops."""
    if not robot.loops:
        return UrdfForm(merged)
    couplings = linear_couplings(robot, home(robot), preferred_drivers)
    return UrdfForm(merged, couplings, closed_loops(robot, couplings))


def urdf_robot(robot: Robot, form: UrdfForm, held: Holders) -> Robot:
    """Returns the robot that a URDF of this form describes: the content of merged links is moved to the links
    that hold them (`held`), and each <mimic> is a relation."""
    robot = replace(robot, relations=_relations(robot, form), mjcf=None)
    if all(holder == link for link, (holder, _) in held.items()):
        return robot
    merged_robot = fused(robot, held)
    names = {joint.name: joint.name for joint in merged_robot.joints}
    controls = (with_joints(text, names)[0] for text in robot.controls)
    return replace(merged_robot, controls=tuple(text for text in controls if text))


def _relations(robot: Robot, form: UrdfForm) -> tuple[Relation, ...]:
    """Returns the relations of the robot and of its loops. Chains are resolved: no driver is a follower."""
    exact = {mimic.follower: mimic for mimic in form.mimics}
    relations = []
    for relation in robot.relations:
        driver_mimic = exact.get(relation.driver)
        if driver_mimic is not None:
            offset = relation.multiplier * driver_mimic.offset + relation.offset
            factor = relation.multiplier * driver_mimic.multiplier
            relation = replace(relation, driver=driver_mimic.driver, multiplier=factor, offset=offset)
        relations.append(relation)
    used_names = {relation.name for relation in robot.relations} | {loop.name for loop in robot.loops}
    for mimic in form.mimics:
        name = free(f"{mimic.follower}_mimic", used_names)
        used_names.add(name)
        relations.append(Relation(name, mimic.follower, mimic.driver, mimic.multiplier, mimic.offset))
    return tuple(relations)
