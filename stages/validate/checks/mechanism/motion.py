"""The model moves as the robot does: links and frames at configurations spread over the dofs' values."""

from linkwright.stages.validate.read.compiled import compared
from linkwright.stages.validate.same.motion import motion

check = compared(motion)
