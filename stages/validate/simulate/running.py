"""A compiled model made to run in another way than its file says, and states to run it from."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.model.robot import Array

DEEP = 5e-4
"""Contacts at the start may be so deep [m], the skin of soft contact: deeper ones push the robot apart."""


@contextmanager
def with_options(model: Any, **options: Any) -> Iterator[None]:
    """The model with these members of its `option`, for as long as the context lasts."""
    before = {name: getattr(model.opt, name) for name in options}
    try:
        for name, value in options.items():
            setattr(model.opt, name, value)
        yield
    finally:
        for name, value in before.items():
            setattr(model.opt, name, value)


def flags(*names: str) -> int:
    """The bits of these flags that turn something off, as far as the installed MuJoCo has them."""
    bits = (getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}", 0) for name in names)
    return sum(int(bit) for bit in bits)


PASSIVE = ("PASSIVE", "SPRING", "DAMPER")
"""Springs, dampers, fluids and the compensation of gravity: one flag in older versions of MuJoCo, two in
newer ones."""


@dataclass(frozen=True, slots=True)
class Touching:
    """Two bodies in contact, and how deep [m]; the world, 0, is always the other. `geom`: of the world, what
    is touched of it; -1 of another body."""

    body: int
    other: int
    depth: float
    geom: int = -1


def touching(model: Any, data: Any) -> list[Touching]:
    """What is in contact, the deepest first, each pair of bodies, and each body with each thing of the world,
    with its deepest contact."""
    found: dict[tuple[int, int, int], float] = {}
    for contact in data.contact[: data.ncon]:
        geoms = sorted(contact.geom, key=lambda geom: model.geom_bodyid[geom], reverse=True)
        body, other = (int(model.geom_bodyid[geom]) for geom in geoms)
        key = body, other, int(geoms[1]) if other == 0 else -1
        found[key] = max(found.get(key, 0.0), -float(contact.dist))
    every = (Touching(body, other, depth, geom) for (body, other, geom), depth in found.items())
    return sorted(every, key=lambda one: -one.depth)


def drawn(name: str, count: int) -> Array:
    """`count` numbers spread evenly over -1 to 1, always the same ones for a name (PCG64): the order of what
    has names does not matter."""
    seed = int.from_bytes(hashlib.sha256(name.encode()).digest()[:16], "big")
    return 2.0 * np.random.Generator(np.random.PCG64(seed)).random(count) - 1.0
