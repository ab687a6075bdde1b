"""A primitive of the kind, and of the lengths, that the user names."""

from collections.abc import Sequence
from typing import cast

from linkwright.stages.formats.meshes.surface import Surface, joined
from linkwright.stages.mesh.collide.acceptance import measured
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import GivenSettings
from linkwright.stages.mesh.fit import fit_one
from linkwright.stages.robot.model.robot import PrimitiveKind


def make(surfaces: Sequence[Surface], settings: GivenSettings) -> Collision:
    """However well it fits; none of what lies in a plane."""
    found = fit_one(cast("PrimitiveKind", settings.kind), joined(surfaces), settings.size)
    if found is None:
        return Collision(note="it is flat")
    return measured(Collision((found,), rung=found.kind), surfaces, settings.tolerance)
