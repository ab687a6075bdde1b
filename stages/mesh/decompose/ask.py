"""Asks the guest for a decomposition, within limits of time and memory."""

from __future__ import annotations

import hashlib
import threading
from functools import cache
from importlib import metadata
from typing import Any

import numpy as np

from stages.mesh.decompose import wire
from stages.mesh.decompose.wire import Decomposition
from stages.mesh.decompose_options import DecomposeOptions
from stages.mesh.snapping import snapped
from stages.mesh.surface import Surface
from stages.robot.errors import DecompositionFailed
from stages.robot.guest import ONE_THREAD, Bounds, Ended, Guest

GUEST = "stages.mesh.decompose.coacd_guest"

BOUNDS = Bounds(seconds=60, memory=2 << 30, reply=64 << 20, shared=4)
"""Limits of one decomposition, the time that of its processor: by the clock it would depend on what else the
machine does whether a part is decomposed."""


def decomposer(halt: threading.Event | None = None, module: str = GUEST, bounds: Bounds = BOUNDS) -> Guest:
    """A guest that decomposes surface after surface."""
    return Guest(module, bounds, ONE_THREAD, halt)


def decomposition(surface: Surface, options: DecomposeOptions, guest: Guest) -> bytes:
    """The decomposition of a surface as bytes, to cache by `decomposition_key`; `wire.read` reads them.

    Raises DecompositionFailed where the guest takes too long, needs too much memory, crashes, or gives a
    reply that is none: nothing to keep, since it may not happen again. What follows from the mesh itself is
    a result, with `refused`.
    """
    if not np.isfinite(surface.vertices).all():
        return wire.write(Decomposition((), "a coordinate of the mesh is not a number"))
    canonical = snapped(surface)
    if not len(canonical.triangles):
        return wire.write(Decomposition((), "the mesh has no triangle"))
    head = {"tolerance": options.tolerance, "arguments": options.arguments}
    try:
        reply = guest.ask(wire.request(canonical, head))
        wire.read(reply)
    except Ended as ended:
        msg = f"the decomposition {ended}"
    except ValueError:
        guest.close()
        msg = "the decomposition gave a reply that is none"
    else:
        return reply
    raise DecompositionFailed(msg, hint="a larger tolerance, or mesh.effort: low, makes it faster")


def decomposition_key(surface: Surface, options: DecomposeOptions) -> dict[str, Any]:
    """What a decomposition depends on, as plain data: the shape, the options and the libraries.

    How many pieces and vertices are asked for is no part of it: they are joined afterwards.
    """
    canonical = snapped(surface)
    shape = hashlib.sha256(canonical.vertices.astype("<f8").tobytes())
    shape.update(canonical.triangles.astype("<i8").tobytes())
    return {
        "shape": shape.hexdigest(),
        "tolerance": options.tolerance.hex(),
        "arguments": {
            name: value.hex() if isinstance(value, float) else value
            for name, value in options.arguments.items()
        },
        "libraries": _versions(),
    }


@cache
def _versions() -> dict[str, str]:
    return {name: metadata.version(name) for name in ("coacd", "manifold3d", "numpy", "scipy")}
