"""The forces with which driven dofs hold a robot in each of its keyframes."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from linkwright.stages.export.actuators.loads import LoadBounds, along
from linkwright.stages.robot.dynamics.statics import GroundSupport, holding_forces
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.couplings import Couplings
from linkwright.stages.robot.motion.pose_batch import repeated
from linkwright.stages.robot.motion.start_pose import keyframes

GroundSupports = Callable[[Configuration], Sequence[GroundSupport]]
"""What the ground carries of a free robot at a pose; nothing where the robot does not stand."""

Holds = Mapping[str, Mapping[str, float]]
"""By dof, by keyframe: the force [N m or N], with its sign."""


def holding(
    robot: Robot, driven: Sequence[str], bounds: LoadBounds, up: Array, supports: GroundSupports
) -> dict[str, dict[str, float]]:
    """By driven dof and keyframe: the force that holds the weight there. A free robot that does not stand has
    none. `up` (3,) [m/s²]: against gravity, in the root link's axes; `bounds`: of the dofs of loops."""
    kinds = {dof.name: dof.kind for dof in robot.dofs}
    holds: dict[str, dict[str, float]] = {dof: {} for dof in driven}
    for name, pose in keyframes(robot).items():
        ground = () if robot.base.fixed else supports(pose)
        if not robot.base.fixed and not ground:
            continue
        values = repeated(pose, 1)
        forces = holding_forces(robot, values, up, ground=ground)
        couplings = Couplings(robot, values)
        for dof, rates in couplings.moved_by(driven).items():
            force = float(along(forces, rates)[0])
            most = bounds.force(kinds[dof]) if dof in couplings.in_loops else np.inf
            holds[dof][name] = min(max(force, -most), most)
    return holds


def standing_nowhere(_: Configuration) -> tuple[GroundSupport, ...]:
    """The supports of a robot in free fall."""
    return ()
