"""The table of the makers of colliders."""

from linkwright.stages.mesh.colliders import coacd, given, hull, ladder, primitives, raw, spheres, visual

MAKERS = {
    "coacd": coacd,
    "given": given,
    "hull": hull,
    "ladder": ladder,
    "primitives": primitives,
    "raw": raw,
    "spheres": spheres,
    "visual": visual,
}
"""By its name, the module of a maker, with its `make` and, where it improves, its `improve`."""
