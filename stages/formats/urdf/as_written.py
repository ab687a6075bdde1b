"""The robot that a URDF describes, where its form differs from that of the robot."""

from collections.abc import Sequence
from dataclasses import replace

from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.urdf.transmissions import with_joints
from linkwright.stages.robot.dynamics.fusing import Holders, fused
from linkwright.stages.robot.model.robot import Relation, Robot
from linkwright.stages.robot.motion.loop_lines import closed_loops, linear_couplings
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.text.names import free


def form_with(robot: Robot, merged: bool = False, first: Sequence[str] = ()) -> UrdfForm:
    """The form of a robot's URDF. `first`: the dofs that drive others in closed loops, where they can."""
    if not robot.loops:
        return UrdfForm(merged)
    couplings = linear_couplings(robot, home(robot), first)
    return UrdfForm(merged, couplings, closed_loops(robot, couplings))


def as_written(robot: Robot, form: UrdfForm, held: Holders) -> Robot:
    """The robot that the URDF of this form describes: with all that was on merged links on their holders
    `held`, and with a relation for each <mimic>."""
    robot = replace(robot, relations=_relations(robot, form), mjcf=None)
    if all(holder == link for link, (holder, _) in held.items()):
        return robot
    whole = fused(robot, held)
    names = {joint.name: joint.name for joint in whole.joints}
    controls = (with_joints(text, names)[0] for text in robot.controls)
    return replace(whole, controls=tuple(text for text in controls if text))


def _relations(robot: Robot, form: UrdfForm) -> tuple[Relation, ...]:
    """The robot's and those of its loops, each relative to a dof that follows no other."""
    exact = {one.follower: one for one in form.mimics}
    found = []
    for relation in robot.relations:
        via = exact.get(relation.driver)
        if via is not None:
            offset = relation.multiplier * via.offset + relation.offset
            factor = relation.multiplier * via.multiplier
            relation = replace(relation, driver=via.driver, multiplier=factor, offset=offset)
        found.append(relation)
    taken = {one.name for one in robot.relations} | {loop.name for loop in robot.loops}
    for one in form.mimics:
        name = free(f"{one.follower}_mimic", taken)
        taken.add(name)
        found.append(Relation(name, one.follower, one.driver, one.multiplier, one.offset))
    return tuple(found)
