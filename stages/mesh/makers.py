"""Maps the names of collider makers to their modules."""

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
"""Name of a maker → its module, with `make` and, if the maker has a second step, `improve`. The ladder also
has `together`, which makes one collider for several parts."""
