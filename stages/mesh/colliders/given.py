"""Makes a primitive of the kind and the lengths that the user chose."""

from collections.abc import Sequence
from typing import cast

from linkwright.stages.formats.meshes.surface import Surface, join_surfaces
from linkwright.stages.mesh.collide.acceptance import with_measures
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import GivenSettings
from linkwright.stages.mesh.fit import fit_kind
from linkwright.stages.robot.model.robot import PrimitiveKind


def make(surfaces: Sequence[Surface], settings: GivenSettings) -> Collision:
    """Makes the primitive, even if it fits badly; no pieces for a flat part."""
    primitive = fit_kind(cast("PrimitiveKind", settings.kind), join_surfaces(surfaces), settings.size)
    if primitive is None:
        return Collision(note="it is flat")
    return with_measures(Collision((primitive,), rung=primitive.kind), surfaces, settings.tolerance)
