"""Checks that the mass, centre of mass and inertia of each link are those of its parts in CAD."""

from linkwright.stages.validate.read.compiled import compared
from linkwright.stages.validate.same.masses import masses

check = compared(masses)
