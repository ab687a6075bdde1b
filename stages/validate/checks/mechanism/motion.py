"""Checks that the model moves as the robot does, by its links and frames at spread values of the dofs."""

from linkwright.stages.validate.read.compiled import as_model_check
from linkwright.stages.validate.same.motion import compare_motion

check = as_model_check(compare_motion)
