"""Converts a robot to the robot that its URDF describes: links merged, loops replaced by mimics."""

from collections.abc import Sequence
from dataclasses import replace

from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.urdf.transmissions import with_joints
from linkwright.stages.robot.dynamics.fusing import Holders, fused
from linkwright.stages.robot.model.robot import Relation, Robot
from linkwright.stages.robot.motion.loop_lines import closed_loops, linear_couplings
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.text.names import free_name


def urdf_form(robot: Robot, merged: bool = False, preferred_drivers: Sequence[str] = ()) -> UrdfForm:
    """Returns the form of a robot's URDF.

    `merged`: whether links on fixed joints are merged; `preferred_drivers`: names of dofs to prefer as
    drivers of closed loops.
    """
    if not robot.loops:
        return UrdfForm(merged)
    couplings = linear_couplings(robot, home(robot), preferred_drivers)
    return UrdfForm(merged, couplings, closed_loops(robot, couplings))


def urdf_robot(robot: Robot, form: UrdfForm, holders: Holders) -> Robot:
    """Returns the robot that a URDF of this form describes: the content of merged links is moved to the links
    that hold them, and each <mimic> is a relation. `holders`: the holder of each link."""
    robot = replace(robot, relations=_relations(robot, form), mjcf=None)
    if all(holder == link for link, (holder, _) in holders.items()):
        return robot
    merged_robot = fused(robot, holders)
    kept_joints = {joint.name: joint.name for joint in merged_robot.joints}
    # Controls of joints that were merged away are left out.
    controls = (with_joints(xml, kept_joints)[0] for xml in robot.controls)
    return replace(merged_robot, controls=tuple(xml for xml in controls if xml))


def _relations(robot: Robot, form: UrdfForm) -> tuple[Relation, ...]:
    """Returns the robot's relations, and a relation for each <mimic> that replaces a loop.

    A <mimic> must not follow a joint that itself follows another joint. So a relation whose driver follows in
    a loop is expressed by the joint that drives the loop.
    """
    mimic_by_follower = {mimic.follower: mimic for mimic in form.mimics}
    relations = []
    for relation in robot.relations:
        driver_mimic = mimic_by_follower.get(relation.driver)
        if driver_mimic is not None:
            offset = relation.multiplier * driver_mimic.offset + relation.offset
            multiplier = relation.multiplier * driver_mimic.multiplier
            relation = replace(relation, driver=driver_mimic.driver, multiplier=multiplier, offset=offset)
        relations.append(relation)
    used_names = {relation.name for relation in robot.relations} | {loop.name for loop in robot.loops}
    for mimic in form.mimics:
        name = free_name(f"{mimic.follower}_mimic", used_names)
        used_names.add(name)
        relations.append(Relation(name, mimic.follower, mimic.driver, mimic.multiplier, mimic.offset))
    return tuple(relations)
