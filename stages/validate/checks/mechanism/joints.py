"""Checks the type, limits, effort and dynamics of each joint, and that nothing else acts on it."""

from linkwright.stages.validate.read.compiled import compared
from linkwright.stages.validate.same.joints import joints

check = compared(joints)
