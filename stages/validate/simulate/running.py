"""Changes the options of a compiled model for a run, lists its contacts, and draws seeded numbers."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.model.robot import Array

MAX_START_DEPTH = 5e-4
"""Largest depth [m] of contacts at the start: resting bodies sink about as deep into each other by soft
contact, and deeper contacts push the robot apart."""

PASSIVE = ("PASSIVE", "SPRING", "DAMPER")
"""Springs, dampers, fluids and gravity compensation: one flag in older versions of MuJoCo, two in newer
versions."""


@contextmanager
def with_options(model: Any, **options: Any) -> Iterator[None]:
    """Sets members of the model's `option` while the context lasts."""
    earlier_values = {name: getattr(model.opt, name) for name in options}
    try:
        for name, value in options.items():
            setattr(model.opt, name, value)
        yield
    finally:
        for name, value in earlier_values.items():
            setattr(model.opt, name, value)


def flags(*names: str) -> int:
    """Returns the bits of flags that disable features, as far as the installed MuJoCo has these flags."""
    bits = (getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}", 0) for name in names)
    return sum(int(bit) for bit in bits)


@dataclass(frozen=True, slots=True)
class Touching:
    """Two bodies in contact."""

    body: int
    other: int
    """The other body; the world, 0, is always this."""

    depth: float
    """The depth [m] of the contact; 0 if the bodies only come within the margin of contact."""

    geom: int = -1
    """The world's geom that is touched; -1 for another body."""


def touching(model: Any, data: Any) -> list[Touching]:
    """Returns the contacts between geoms, the deepest first. Each pair of bodies, and each body with each
    geom of the world, is listed once with its deepest contact."""
    depths: dict[tuple[int, int, int], float] = {}
    for contact in data.contact[: data.ncon]:
        # A flex, which belongs to no single body, has the geom -1.
        if min(contact.geom) < 0:
            continue
        geoms = sorted(contact.geom, key=lambda geom: model.geom_bodyid[geom], reverse=True)
        body, other = (int(model.geom_bodyid[geom]) for geom in geoms)
        key = body, other, int(geoms[1]) if other == 0 else -1
        depths[key] = max(depths.get(key, 0.0), -float(contact.dist))
    contacts = (Touching(body, other, depth, geom) for (body, other, geom), depth in depths.items())
    return sorted(contacts, key=lambda contact: -contact.depth)


def seeded_numbers(name: str, count: int) -> Array:
    """Returns `count` random numbers in -1 to 1, always the same for a name (PCG64), so that the order of
    named elements does not matter."""
    seed = int.from_bytes(hashlib.sha256(name.encode()).digest()[:16], "big")
    return 2.0 * np.random.Generator(np.random.PCG64(seed)).random(count) - 1.0
