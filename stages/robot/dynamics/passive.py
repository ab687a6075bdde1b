"""The joints that nothing drives: neither an actuator, nor a relation."""

from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.couplings import Couplings, nearest_first
from linkwright.stages.robot.motion.pose_batch import repeated
from linkwright.stages.robot.motion.start_pose import home


def passive_dofs(robot: Robot, written: Robot, actuation: Actuation) -> tuple[str, ...]:
    """The dofs that nothing drives and that follow none, in the order of the robot. `written`: the robot as
    its URDF has it. Of a robot without actuators it is those of closed loops that the others determine, and
    those that the source's SRDF says."""
    followers = {one.follower for one in written.relations}
    driven = {one.dof for one in actuation.actuators} | {one.joint for one in robot.transmissions}
    if driven:
        return tuple(one.name for one in robot.dofs if one.name not in followers | driven)
    said = {*robot.semantics.passive} - followers
    if not robot.loops:
        return tuple(one.name for one in robot.dofs if one.name in said)
    couplings = Couplings(robot, repeated(home(robot), 1))
    rest = couplings.in_loops - followers - set(couplings.independent(nearest_first(robot)))
    return tuple(one.name for one in robot.dofs if one.name in rest | said)
