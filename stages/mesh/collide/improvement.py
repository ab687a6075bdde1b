"""The second, costly step of a maker of colliders, in a guest process with limits of time and memory: CoACD
crashes on some meshes, and never ends on others."""

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

BOUNDS = Bounds(seconds=120, memory=4 << 30, reply=64 << 20, shared=4)
"""Limits of one part, the time that of its processor: by the clock it would depend on what else the machine
does whether a part has pieces."""


@dataclass(frozen=True, slots=True, eq=False)
class Improvement:
    """What a maker is to improve: its `made` of these surfaces."""

    maker: str
    surfaces: Sequence[Surface]
    settings: ColliderSettings
    made: Collision

    def reply(self) -> bytes:
        """The improved collider, as bytes."""
        return collision.encode(MAKERS[self.maker].improve(self.surfaces, self.settings, self.made))


def helper(halt: threading.Event | None = None, module: str = TASKS, bounds: Bounds = BOUNDS) -> Guest:
    """A guest that improves collider after collider."""
    return Guest(module, bounds, ONE_THREAD, halt)


def improved(task: Improvement, guest: Guest) -> bytes:
    """The improved collider, as bytes.

    Raises DecompositionFailed where the guest takes too long, needs too much memory, crashes, or gives a
    reply that is none: nothing to keep, since it may not happen again.
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
        msg = "the decomposition gave a reply that is none"
        raise DecompositionFailed(msg, hint=hint) from None
    return reply
