"""Computes the forces with which driven dofs hold a robot in each of its keyframes."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from linkwright.stages.export.actuators.loads import LoadBounds, combined_force
from linkwright.stages.robot.dynamics.statics import GroundSupport, holding_forces
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.couplings import Couplings
from linkwright.stages.robot.motion.pose_batch import repeated
from linkwright.stages.robot.motion.start_pose import keyframes

GroundSupports = Callable[[Robot, Configuration], Sequence[GroundSupport]]
"""(robot, configuration) → the forces of the ground on the free robot; empty if it does not stand. The robot
has only the weight that gravity compensation leaves, since the ground carries no more."""

Holds = Mapping[str, Mapping[str, float]]
"""Dof → keyframe → signed holding force [N m or N]."""


def keyframe_forces(
    robot: Robot, driven: Sequence[str], bounds: LoadBounds, up: Array, supports: GroundSupports
) -> dict[str, dict[str, float]]:
    """Returns, by driven dof and keyframe, the force [N m or N] that holds the weight. A keyframe in which a
    free robot does not stand has no forces. `robot`: without its compensated weight; `up` (3,) [m/s²]:
    opposite to gravity, in the root link's axes; `bounds`: the limits of forces at dofs of loops."""
    kinds = {dof.name: dof.kind for dof in robot.dofs}
    holds: dict[str, dict[str, float]] = {dof: {} for dof in driven}
    for name, pose in keyframes(robot).items():
        ground = () if robot.base.fixed else supports(robot, pose)
        if not robot.base.fixed and not ground:
            continue
        values = repeated(pose, 1)
        forces = holding_forces(robot, values, up, ground=ground)
        couplings = Couplings(robot, values)
        for dof, rates in couplings.moved_by(driven).items():
            force = float(combined_force(forces, rates)[0])
            limit = bounds.force(kinds[dof]) if dof in couplings.in_loops else np.inf
            holds[dof][name] = min(max(force, -limit), limit)
    return holds


def no_supports(robot: Robot, pose: Configuration) -> tuple[GroundSupport, ...]:
    """Returns the supports of a robot in free fall: an empty tuple."""
    return ()
