"""Runs the second, costly step of a collider maker in a guest process with limits on time and memory, since
CoACD crashes on some meshes, and does not terminate on others."""

from __future__ import annotations

import pickle
import struct
import threading
from collections.abc import Sequence
from dataclasses import dataclass

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.collide import collision
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import ColliderSettings
from linkwright.stages.mesh.makers import MAKERS
from linkwright.stages.robot.errors import DecompositionFailed
from linkwright.stages.robot.system.guest import ONE_THREAD, Bounds, Ended, Guest

TASKS = "linkwright.stages.mesh.collide.task_guest"

BOUNDS = Bounds(seconds=120, memory=4 << 30, reply=64 << 20, wall_time_factor=4)
"""Limits for a single part. The time is processor time: with wall-clock time, the load of the machine would
decide whether a part gets pieces."""


@dataclass(frozen=True, slots=True, eq=False)
class Improvement:
    """A task: a maker improves the collider that it made from some surfaces."""

    maker: str
    surfaces: Sequence[Surface]
    settings: ColliderSettings
    first_collider: Collision
    """The collider that the maker's first step made."""

    def reply(self) -> bytes:
        """Makes the improved collider, in the guest process, and returns it as bytes."""
        return collision.encode(MAKERS[self.maker].improve(self.surfaces, self.settings, self.first_collider))


def helper(halt: threading.Event | None = None, module: str = TASKS, bounds: Bounds = BOUNDS) -> Guest:
    """Returns a guest that improves any number of colliders, one after the other."""
    return Guest(module, bounds, ONE_THREAD, halt)


def improved(task: Improvement, guest: Guest) -> bytes:
    """Returns the improved collider of a guest, as bytes.

    Raises DecompositionFailed if the guest takes too long, needs too much memory, crashes, or returns an
    invalid reply. The failure is not cached, since it may not happen again.
    """
    hint = "a larger tolerance, or mesh.effort: low, makes it faster"
    try:
        reply = guest.ask(pickle.dumps(task))
    except Ended as ended:
        msg = f"the decomposition {ended}"
        raise DecompositionFailed(msg, hint=hint) from None
    try:
        collision.decode(reply)
    except (ValueError, TypeError, KeyError, AttributeError, struct.error):
        guest.close()
        msg = "the decomposition returned an invalid reply"
        raise DecompositionFailed(msg, hint=hint) from None
    return reply
