"""Checks that every part is where CAD's occurrence has it, at the saved configuration."""

from linkwright.stages.validate.read.compiled import compared
from linkwright.stages.validate.same.motion import poses

check = compared(poses)
