"""Makes the collider of a part from the primitive that fits best."""

from collections.abc import Sequence

from linkwright.stages.formats.meshes.surface import Surface, join_surfaces
from linkwright.stages.mesh.collide.acceptance import with_measures
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import PrimitiveSettings
from linkwright.stages.mesh.fit import allowed_kinds, best_primitive


def make(surfaces: Sequence[Surface], settings: PrimitiveSettings) -> Collision:
    """Makes the primitive with the smallest error, however large that error is. A flat part has no primitive:
    its collider has no pieces, and a note."""
    primitive = best_primitive(join_surfaces(surfaces), allowed_kinds(settings.limits))
    if primitive is None:
        return Collision(note="it is flat")
    return with_measures(Collision((primitive,), rung=primitive.kind), surfaces, settings.tolerance)
