"""Checks that the mass, centre of mass and inertia of each link are those of its parts in CAD."""

from linkwright.stages.validate.read.compiled import as_model_check
from linkwright.stages.validate.same.masses import compare_masses

check = as_model_check(compare_masses)
