"""Finds the dofs that neither an actuator nor a relation drives."""

from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.couplings import Couplings, nearest_first
from linkwright.stages.robot.motion.pose_batch import repeated
from linkwright.stages.robot.motion.start_pose import home


def passive_dofs(robot: Robot, urdf_robot: Robot, actuation: Actuation) -> tuple[str, ...]:
    """Returns the dofs of the tree that no actuator or transmission drives and that follow no other dof, in
    the order of the robot. If nothing drives the robot, these are the dofs that closed loops determine from
    the others, and the passive joints of the source's SRDF.

    `urdf_robot`: the robot as its URDF has it, whose relations tell which dofs follow others.
    """
    followers = {relation.follower for relation in urdf_robot.relations}
    driven = {actuator.dof for actuator in actuation.actuators} | {
        transmission.joint for transmission in robot.transmissions
    }
    if driven:
        return tuple(dof.name for dof in robot.dofs if dof.name not in followers | driven)
    passive_in_srdf = {*robot.semantics.passive} - followers
    if not robot.loops:
        return tuple(dof.name for dof in robot.dofs if dof.name in passive_in_srdf)
    couplings = Couplings(robot, repeated(home(robot), 1))
    determined = couplings.in_loops - followers - set(couplings.independent(nearest_first(robot)))
    return tuple(dof.name for dof in robot.dofs if dof.name in determined | passive_in_srdf)
