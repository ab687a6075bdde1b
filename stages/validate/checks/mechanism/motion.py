"""Checks that the model moves as the robot does, by its links and frames at spread values of the dofs."""

from linkwright.stages.validate.read.compiled import compared
from linkwright.stages.validate.same.motion import motion

check = compared(motion)
