"""Checks that every part is where CAD's occurrence has it, at the saved configuration."""

from linkwright.stages.validate.read.compiled import as_model_check
from linkwright.stages.validate.same.motion import compare_with_cad

check = as_model_check(compare_with_cad)
