"""Checks the type, limits, effort and dynamics of each joint, and that nothing else acts on it."""

from linkwright.stages.validate.read.compiled import as_model_check
from linkwright.stages.validate.same.joints import compare_joints

check = as_model_check(compare_joints)
